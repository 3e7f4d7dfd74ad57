//! The part of a plane that lies in the box, and what a field is on it.

use crate::field::Field;
use crate::view::{single, unit};
use tremie_geometry::Vec3;
use tremie_messages::Stamp;
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::Domain;

/// A rectangle around the part of a plane that lies in the box.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    origin: Vec3,
    /// Edges [m].
    sides: [Vec3; 2],
}

/// Corner of the box whose side along axis `a` is the upper one if bit `a` of `k` is set.
pub fn corner(domain: &Domain, k: usize) -> Vec3 {
    Vec3::from_fn(|a, _| if k >> a & 1 == 1 { domain.max[a] } else { domain.min[a] })
}

/// Corners that edges of the box join.
pub fn corner_pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..8).flat_map(|k| (0..3).map(move |a| (k, k | 1 << a))).filter(|(k, l)| k != l)
}

/// Corners of the part of a plane that lies in the box, in the order around it; none if it misses
/// it.
pub fn polygon(domain: &Domain, point: Vec3, normal: Vec3) -> Vec<Vec3> {
    let height = |p: Vec3| (p - point).dot(&normal);
    let mut points: Vec<Vec3> = corner_pairs()
        .filter_map(|(k, l)| {
            let (p, q) = (corner(domain, k), corner(domain, l));
            let (a, b) = (height(p), height(q));
            (a * b < 0.0).then(|| p + (q - p) * (a / (a - b)))
        })
        .collect();
    let count = points.len();
    let Some(first) = points.first() else { return points };
    let middle = points.iter().sum::<Vec3>() / count as f64;
    let first = unit(*first - middle);
    let second = normal.cross(&first);
    let angle = |p: &Vec3| {
        let r = *p - middle;
        r.dot(&second).atan2(r.dot(&first))
    };
    points.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    points
}

impl Patch {
    /// The patch of a plane; `None` if the plane misses the box.
    pub fn new(domain: &Domain, point: Vec3, normal: Vec3) -> Option<Self> {
        let normal = unit(normal);
        let points = polygon(domain, point, normal);
        // Along an edge of the box where the plane is.
        let axis = (0..3).min_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs()))?;
        let edge = Vec3::ith(axis, 1.0);
        let first = unit(edge - normal * edge.dot(&normal));
        let axes = [first, normal.cross(&first)];
        let span = axes.map(|axis| {
            let places = points.iter().map(|p| (*p - point).dot(&axis));
            [places.clone().fold(f64::INFINITY, f64::min), places.fold(-f64::INFINITY, f64::max)]
        });
        if points.is_empty() {
            return None;
        }
        let origin = point + axes[0] * span[0][0] + axes[1] * span[1][0];
        let sides = [0, 1].map(|k| axes[k] * (span[k][1] - span[k][0]));
        Some(Self { origin, sides })
    }

    /// The point at shares `r` and `s` of its edges.
    pub fn point(&self, r: f64, s: f64) -> Vec3 {
        self.origin + self.sides[0] * r + self.sides[1] * s
    }

    /// A field on the patch, with nodes as far apart as the field's. What is neither fluid nor air
    /// is solid.
    pub fn sample(&self, field: &Field<'_>) -> (SliceHeader, Vec<SliceNode>) {
        let steps = self.sides.map(|side| (side.norm() / field.spacing()).ceil().max(1.0));
        let step = [0, 1].map(|k| self.sides[k] / steps[k]);
        let count = steps.map(|n| n as u64 + 1);
        let node = |i: u64, j: u64| {
            let point = self.origin + step[0] * (i as f64) + step[1] * (j as f64);
            match field.at(point) {
                Some(sample) => SliceNode {
                    velocity: single(sample.velocity),
                    pressure: sample.pressure as f32,
                    fill: 1.0,
                    solid: 0,
                    density: sample.density as f32,
                    level: sample.level,
                },
                None if field.is_air(point) => SliceNode::default(),
                None => SliceNode { solid: 1, ..SliceNode::default() },
            }
        };
        let nodes = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| node(i, j))).collect();
        let (origin, step) = (self.origin.into(), step.map(Into::into));
        (SliceHeader { stamp: Stamp::default(), origin, step, count }, nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::volume;
    use tremie_messages::scene::Face;

    fn domain() -> Domain {
        Domain::new([0.0; 3], [4.0, 2.0, 3.0], Face::WALLS)
    }

    #[test]
    fn a_plane_across_an_axis_covers_the_box() {
        let patch = Patch::new(&domain(), [9.0, 1.5, 9.0].into(), [0.0, -2.0, 0.0].into()).unwrap();
        let corners = [patch.point(0.0, 0.0), patch.point(1.0, 1.0)];
        for (axis, [low, high]) in [(0, [0.0, 4.0]), (1, [1.5, 1.5]), (2, [0.0, 3.0])] {
            let mut found = corners.map(|c| c[axis]);
            found.sort_by(f64::total_cmp);
            assert!((found[0] - low).abs() + (found[1] - high).abs() < 1e-12, "{corners:?}");
        }
        assert!(Patch::new(&domain(), [9.0, 5.0, 9.0].into(), [0.0, 1.0, 0.0].into()).is_none());
    }

    #[test]
    fn an_oblique_patch_holds_the_whole_cut() {
        let (point, normal) = (Vec3::new(2.0, 1.0, 1.5), unit(Vec3::new(1.0, 0.4, -0.3)));
        let patch = Patch::new(&domain(), point, normal).unwrap();
        for p in polygon(&domain(), point, normal) {
            let r = p - patch.origin;
            for side in patch.sides {
                let share = r.dot(&side) / side.dot(&side);
                assert!((-1e-9..=1.0 + 1e-9).contains(&share), "{share}");
            }
        }
        assert!((patch.point(0.3, 0.8) - point).dot(&normal).abs() < 1e-12);
    }

    #[test]
    fn a_field_is_sampled_on_it() {
        let (header, nodes) = volume([4, 2, 3], |p| SliceNode {
            velocity: [p[0] as f32, 0.0, 0.0],
            pressure: p[2] as f32,
            fill: 1.0,
            ..SliceNode::default()
        });
        let field = Field::new(&header, &nodes).unwrap();
        let patch = Patch::new(&domain(), [0.0, 1.0, 0.0].into(), [0.0, 1.0, 0.0].into()).unwrap();
        let (header, nodes) = patch.sample(&field);
        assert_eq!(header.count.iter().product::<u64>(), 5 * 4);
        for (k, node) in nodes.iter().enumerate() {
            let (i, j) = (k as u64 % header.count[0], k as u64 / header.count[0]);
            let at = |a: usize| {
                header.origin[a] + i as f64 * header.step[0][a] + j as f64 * header.step[1][a]
            };
            // Constant over the last half cell.
            assert_eq!(f64::from(node.velocity[0]), at(0).clamp(0.5, 3.5), "{k}");
            assert_eq!(f64::from(node.pressure), at(2).clamp(0.5, 2.5), "{k}");
        }
    }
}
