//! Crossings of segments and a surface, decided exactly.

use crate::exact::{Corners, agree, below, on_triangle, turn, turns};
use crate::surface::Surface;
use crate::tree::Walk;
use crate::{Bounds, Vec3};

/// The first crossing of a segment and a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Part of the segment before it, from 0 to 1; 0 only if the segment starts on the surface.
    pub fraction: f64,
    /// The triangle; of several at the same place the first.
    pub triangle: u32,
}

impl Surface {
    /// The first point that a segment and the surface have in common.
    ///
    /// Decided by exact predicates, as [`Surface::contains`] is: if exactly one end is in the
    /// solid, there is a crossing; a segment between two triangles misses none. The fraction is
    /// rounded.
    pub fn first_crossing(&self, from: impl Into<Vec3>, to: impl Into<Vec3>) -> Option<Crossing> {
        self.first_met(from.into(), to.into())
    }

    /// As [`Surface::first_crossing`]. In one piece here, not again in each crate that asks.
    fn first_met(&self, from: Vec3, to: Vec3) -> Option<Crossing> {
        let best = std::cell::Cell::new(None::<Crossing>);
        let segment = Segment::new(from, to);
        let within = |b: &Bounds| {
            segment.entry(b).is_some_and(|t| best.get().is_none_or(|best| t <= best.fraction))
        };
        self.tree.walk(within, |triangle, corners| {
            if let Some(fraction) = meet(corners, from, to) {
                let nearer = |b: Crossing| (fraction, triangle) < (b.fraction, b.triangle);
                if best.get().is_none_or(nearer) {
                    best.set(Some(Crossing { fraction, triangle }));
                }
            }
            Walk::On
        });
        best.get()
    }

    /// The same as [`Surface::first_crossing`], if `triangles` are all that the segment may meet:
    /// those that [`Surface::triangles_in`] finds in a box around it. For many short segments at
    /// one place. Where triangles meet, it may name another of them, and the fraction differ by
    /// rounding.
    pub fn first_crossing_among(
        &self,
        triangles: &[u32],
        from: impl Into<Vec3>,
        to: impl Into<Vec3>,
    ) -> Option<Crossing> {
        self.first_met_among(triangles, from.into(), to.into())
    }

    /// As [`Surface::first_crossing_among`].
    fn first_met_among(&self, triangles: &[u32], from: Vec3, to: Vec3) -> Option<Crossing> {
        let mut best = None::<Crossing>;
        for &triangle in triangles {
            if let Some(fraction) = meet(&self.mesh.corners(triangle as usize), from, to)
                && best.is_none_or(|b| (fraction, triangle) < (b.fraction, b.triangle))
            {
                best = Some(Crossing { fraction, triangle });
            }
        }
        best
    }

    /// Puts into `out` the triangles that a box may hold a part of: all that do, and a few that do
    /// not. False if there are more than `most`; the list is then of no use. Allocates only where
    /// `out` has to grow.
    pub fn triangles_in(&self, bounds: &Bounds, most: usize, out: &mut Vec<u32>) -> bool {
        out.clear();
        let centre = bounds.centre();
        let half = bounds.max - centre;
        self.tree.walk(
            |b| b.meets(bounds),
            |triangle, corners| {
                if Bounds::of(*corners).meets(bounds) && is_near(corners, centre, half) {
                    out.push(triangle);
                }
                if out.len() > most { Walk::Stop } else { Walk::On }
            },
        );
        out.len() <= most
    }
}

/// True if a box is on no outer side of a triangle's plane and of the planes that stand on its
/// edges; in doubt it is not.
fn is_near(corners: &Corners, centre: Vec3, half: Vec3) -> bool {
    let [a, b, c] = *corners;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(&ac);
    let long = |v: Vec3| v[0].abs() + v[1].abs() + v[2].abs();
    // What rounding can do to the normal, for each unit of distance from the triangle.
    let rounding = 64.0 * f64::EPSILON * long(ab) * long(ac);
    let is_off = |n: Vec3, from: Vec3, rounding: f64| {
        let away = centre - from;
        let reach = n[0].abs() * half[0] + n[1].abs() * half[1] + n[2].abs() * half[2];
        n.dot(&away) > reach * (1.0 + 1e-9) + rounding * (long(away) + long(half))
    };
    let opposite = normal.map(|n| -n);
    let beside = |from: Vec3, to: Vec3| {
        let edge = to - from;
        is_off(edge.cross(&normal), from, rounding * long(edge))
    };
    !(is_off(normal, a, rounding)
        || is_off(opposite, a, rounding)
        || beside(a, b)
        || beside(b, c)
        || beside(c, a))
}

/// A segment, prepared for the question whether it meets boxes.
pub struct Segment {
    from: Vec3,
    to: Vec3,
    inverse: Vec3,
}

/// Growth that covers the four roundings in a quotient below (Ize, *J. Comput. Graphics Techniques*
/// 2 (2013) 12).
const ROUNDED_UP: f64 = 1.0 + 8.0 * f64::EPSILON;

impl Segment {
    pub fn new(from: Vec3, to: Vec3) -> Self {
        Self { from, to, inverse: Vec3::from_fn(|k, _| 1.0 / (to[k] - from[k])) }
    }

    /// At or shortly before which fraction the segment enters a box. Never misses one it meets.
    #[inline]
    pub fn entry(&self, bounds: &Bounds) -> Option<f64> {
        self.span(bounds).map(|(first, _)| first)
    }

    /// Fractions between which the segment is in a box, rounded outward.
    #[inline]
    pub fn span(&self, bounds: &Bounds) -> Option<(f64, f64)> {
        let (mut first, mut last) = (0.0f64, 1.0f64);
        for k in 0..3 {
            let (low, high) = (bounds.min[k] - self.from[k], bounds.max[k] - self.from[k]);
            if self.from[k] == self.to[k] {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low * self.inverse[k], high * self.inverse[k]);
            first = first.max(a.min(b) / ROUNDED_UP);
            last = last.min(a.max(b) * ROUNDED_UP);
        }
        (first <= last).then_some((first, last.min(1.0)))
    }
}

/// Part of a segment before the point that it shares with a triangle.
fn meet(triangle: &Corners, from: Vec3, to: Vec3) -> Option<f64> {
    let (start, end) = (below(triangle, from), below(triangle, to));
    if (start > 0.0 && end > 0.0) || (start < 0.0 && end < 0.0) {
        return None;
    }
    if start == 0.0 && end == 0.0 {
        // In the triangle's plane: where the segment comes in from outside, it crosses an edge, and
        // the nearest neighbour that is not in the plane has that edge, or one before it.
        return on_triangle(triangle, from).then_some(0.0);
    }
    let [a, b, c] = *triangle;
    let around = [below(&[from, to, a], b), below(&[from, to, b], c), below(&[from, to, c], a)];
    if !agree(around) {
        return None;
    }
    if start == 0.0 {
        return Some(0.0);
    }
    let fraction = clipped(start / (start - end), triangle, from, to, (start - end).abs());
    // A segment that starts off the surface crosses it later than at once, however it is rounded.
    Some(fraction.max(f64::MIN_POSITIVE))
}

/// Sine of the angle to a triangle's plane below which it is worth looking at the edges as well.
const GRAZING: f64 = 1e-2;

/// A fraction that came from distances from a triangle's plane, made to lie in the triangle.
///
/// The flatter a segment meets the plane, the less those distances say where: rounding is divided
/// by the sine of the angle. An edge that the segment passes at a larger angle knows better.
fn clipped(fraction: f64, triangle: &Corners, from: Vec3, to: Vec3, climb: f64) -> f64 {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(&(c - a));
    let length = (to - from).norm();
    let edges = [(b - a).norm(), (c - b).norm(), (a - c).norm()];
    let longest = edges[0].max(edges[1]).max(edges[2]);
    // The sine of the angle, or less for a slender triangle: its normal is not as sure.
    let sine = climb / (longest * longest * length);
    if sine > GRAZING {
        return fraction;
    }
    let larger =
        |best: usize, k: usize| if normal[k].abs() > normal[best].abs() { k } else { best };
    let axis = (0..3).fold(0, larger);
    let inward = if turn(axis, a, b, c) > 0.0 { 1.0 } else { -1.0 };
    let (starts, ends) = (turns(axis, triangle, from), turns(axis, triangle, to));
    let mut edges = [0, 1, 2].map(|i| {
        let (start, end) = (inward * starts[i], inward * ends[i]);
        ((start - end).abs() / (edges[i] * length), start, end)
    });
    // What the surest edge says is applied last.
    edges.sort_unstable_by(|x, y| x.0.total_cmp(&y.0));
    edges.iter().filter(|edge| edge.0 > sine).fold(fraction, |t, &(_, start, end)| {
        let there = || start / (start - end);
        match (start < 0.0, end < 0.0) {
            (true, false) => t.max(there()),
            (false, true) => t.min(there()),
            _ => t,
        }
    })
}
