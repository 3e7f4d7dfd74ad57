//! Streamlines: curves along the velocity of one moment, coloured by speed.

use crate::field::Field;
use crate::patch::Patch;
use crate::scale::Scale;
use crate::view::{part, single};
use rerun::components::Radius;
use rerun::{Color, LineStrips3D, RecordingStream, RecordingStreamResult};
use tremie_geometry::Vec3;
use tremie_messages::scene::Domain;

/// Step along a line, in steps of the field.
const STEP: f64 = 0.5;
/// Steps between the points that are drawn.
const THINNING: usize = 2;
/// Longest way to either side of the seed, in diagonals of the domain.
const REACH: f64 = 0.7;
/// Speed where a line ends, of the scale's largest: beyond, its direction is noise.
const STAGNANT: f64 = 2e-3;
/// Colours on the scale that a line may have; a line is cut where its colour changes.
const SHADES: f64 = 24.0;

/// Draws streamlines from fixed seeds, so that they stay where they are while the flow changes.
pub struct Streamlines {
    path: String,
    seeds: Vec<Vec3>,
    reach: f64,
}

impl Streamlines {
    /// `count` lines through the field `name` of `from`, seeded evenly on a patch, or all over the
    /// domain.
    pub fn new(from: &str, name: &str, domain: &Domain, patch: Option<&Patch>, count: u32) -> Self {
        let size = domain.size();
        let seed = |k: u32| {
            let [r, s, t] = [2, 3, 5].map(|base| radical_inverse(k + 1, base));
            match patch {
                Some(patch) => patch.point(r, s),
                None => {
                    let share = [r, s, t];
                    Vec3::from_fn(|a, _| domain.min[a] + share[a] * size[a])
                }
            }
        };
        Self {
            path: format!("scene/streamlines/{}/{}", part(from), part(name)),
            seeds: (0..count).map(seed).collect(),
            reach: REACH * Vec3::from(size).norm(),
        }
    }

    /// Draws the lines of one moment.
    pub fn log(
        &self,
        stream: &RecordingStream,
        field: &Field<'_>,
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        let slowest = STAGNANT * scale.max();
        let mut strips = Vec::new();
        let mut colours = Vec::new();
        for seed in &self.seeds {
            let line = trace(field, *seed, self.reach, slowest);
            for (strip, shade) in shaded(&line, scale.max()) {
                strips.push(strip);
                colours.push(Color::from_u32(scale.colour((shade * scale.max()) as f32)));
            }
        }
        let lines =
            LineStrips3D::new(strips).with_colors(colours).with_radii([Radius::new_ui_points(1.2)]);
        stream.log(self.path.as_str(), &lines)
    }
}

/// Van der Corput's sequence of a base: fills the unit interval evenly, however far one goes.
fn radical_inverse(mut k: u32, base: u32) -> f64 {
    let (mut value, mut share) = (0.0, 1.0);
    while k > 0 {
        share /= f64::from(base);
        value += share * f64::from(k % base);
        k /= base;
    }
    value
}

/// A point of a line and the speed there [m, m/s].
type Point = (Vec3, f64);

/// The streamline through `seed`, from upstream to downstream; empty in a solid or where nothing
/// flows.
fn trace(field: &Field<'_>, seed: Vec3, reach: f64, slowest: f64) -> Vec<Point> {
    let Some(begin) = direction(field, seed, slowest) else { return Vec::new() };
    let mut line = side(field, seed, -1.0, reach, slowest);
    line.reverse();
    line.push((seed, begin.1));
    line.extend(side(field, seed, 1.0, reach, slowest));
    line
}

/// Unit vector along the flow, and its speed; `None` outside the fluid and where it rests.
fn direction(field: &Field<'_>, point: Vec3, slowest: f64) -> Option<(Vec3, f64)> {
    let velocity = field.at(point)?.velocity;
    let speed = velocity.norm();
    (speed > slowest).then(|| (velocity / speed, speed))
}

/// Points on one side of the seed, by the classical method of Runge and Kutta in the arc length.
fn side(field: &Field<'_>, seed: Vec3, sign: f64, reach: f64, slowest: f64) -> Vec<Point> {
    let h = sign * STEP * field.spacing();
    let steps = (reach / h.abs()) as usize;
    let mut points = Vec::new();
    let mut at = seed;
    for step in 1..=steps {
        let Some((next, speed)) = runge_kutta(field, at, h, slowest) else { break };
        at = next;
        if step % THINNING == 0 {
            points.push((at, speed));
        }
    }
    points
}

fn runge_kutta(field: &Field<'_>, at: Vec3, h: f64, slowest: f64) -> Option<Point> {
    let slope = |point: Vec3| direction(field, point, slowest).map(|(along, _)| along);
    let k1 = slope(at)?;
    let k2 = slope(at + k1 * (0.5 * h))?;
    let k3 = slope(at + k2 * (0.5 * h))?;
    let k4 = slope(at + k3 * h)?;
    let mean = (k1 + (k2 + k3) * 2.0 + k4) / 6.0;
    let next = at + mean * h;
    Some((next, direction(field, next, slowest)?.1))
}

/// A line in pieces of one shade each, as shares of the scale.
fn shaded(line: &[Point], max: f64) -> Vec<(Vec<[f32; 3]>, f64)> {
    let shade = |speed: f64| (speed / max * SHADES).min(SHADES - 1.0).floor() / SHADES;
    let mut pieces: Vec<(Vec<[f32; 3]>, f64)> = Vec::new();
    for pair in line.windows(2) {
        let [(from, before), (to, after)] = [pair[0], pair[1]];
        let shade = shade(0.5 * (before + after));
        match pieces.last_mut() {
            Some((piece, last)) if *last == shade => piece.push(single(to)),
            _ => pieces.push((vec![single(from), single(to)], shade)),
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::volume;
    use tremie_messages::frame::SliceNode;

    fn node(velocity: Vec3, solid: bool) -> SliceNode {
        SliceNode {
            velocity: single(velocity),
            fill: 1.0,
            solid: solid.into(),
            ..SliceNode::default()
        }
    }

    #[test]
    fn a_vortex_is_a_circle() {
        // Solid-body rotation about the middle: linear, so that interpolation adds no error.
        let (header, nodes) =
            volume([40, 40, 3], |p| node(Vec3::new(20.0 - p.y, p.x - 20.0, 0.0), false));
        let field = Field::new(&header, &nodes).unwrap();
        let line = trace(&field, Vec3::new(28.0, 20.0, 1.5), 40.0, 1e-6);
        assert!(line.len() > 70, "{}", line.len());
        for (p, speed) in &line {
            let radius = (p[0] - 20.0).hypot(p[1] - 20.0);
            assert!((radius - 8.0).abs() < 1e-4, "{p:?} at {radius}");
            assert!((speed - 8.0).abs() < 1e-4);
            assert_eq!(p[2], 1.5);
        }
        // Anticlockwise: the line goes from upstream to downstream.
        let [a, b] = [line[35].0, line[36].0].map(|p| [p[0] - 20.0, p[1] - 20.0]);
        assert!(a[0] * b[1] - a[1] * b[0] > 0.0);
    }

    #[test]
    fn lines_end_at_solids_at_the_box_and_where_nothing_flows() {
        let (header, nodes) = volume([30, 4, 4], |p| node(Vec3::new(1.0, 0.0, 0.0), p[0] > 20.0));
        let field = Field::new(&header, &nodes).unwrap();
        let line = trace(&field, Vec3::new(10.0, 2.0, 2.0), 100.0, 1e-3);
        let (first, last) = (line[0].0[0], line[line.len() - 1].0[0]);
        assert!((0.0..1.0).contains(&first), "{first}");
        assert!((19.0..=20.0).contains(&last), "{last}");
        assert!(
            trace(&field, Vec3::new(25.0, 2.0, 2.0), 100.0, 1e-3).is_empty(),
            "a seed in a solid"
        );
        assert!(
            trace(&field, Vec3::new(10.0, 2.0, 2.0), 100.0, 2.0).is_empty(),
            "slower than the slowest"
        );
    }

    #[test]
    fn pieces_of_one_shade_join() {
        let line: Vec<Point> = (0..10).map(|k| (Vec3::x() * f64::from(k), f64::from(k))).collect();
        let pieces = shaded(&line, 9.0);
        assert!(pieces.len() > 1);
        assert!(pieces.windows(2).all(|two| two[0].0.last() == two[1].0.first()));
        assert_eq!(shaded(&line, 1e9).len(), 1);
    }

    #[test]
    fn seeds_fill_the_interval_evenly() {
        let mut values: Vec<f64> = (1..=64).map(|k| radical_inverse(k, 2)).collect();
        values.sort_by(f64::total_cmp);
        assert!(values.windows(2).all(|two| two[1] - two[0] < 2.5 / 64.0));
    }
}
