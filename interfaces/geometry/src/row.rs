//! Rows of lattice points, filled fast.

use crate::crossing::Segment;
use crate::exact::Corners;
use crate::surface::Surface;
use crate::tree::Walk;
use crate::{Bounds, Vec3};

/// Points at equal distances on a line, in any direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// The first point [m].
    pub start: Vec3,
    /// From each point to the next [m].
    pub step: Vec3,
}

impl Row {
    /// Point `i`, exactly as [`Surface::fill_row`] takes it: `start + i step`, rounded twice.
    pub fn point(&self, i: usize) -> Vec3 {
        Vec3::from_fn(|k, _| self.start[k] + i as f64 * self.step[k])
    }
}

/// Memory of [`Surface::fill_row`], kept so that filling rows allocates nothing. One for each
/// thread.
#[derive(Clone, Debug, Default)]
pub struct RowScratch {
    /// True if the surface may pass between a point and the one before.
    passed: Vec<bool>,
}

impl Surface {
    /// Says for each point of a row whether it is in the solid, its surface included: the same
    /// as [`Surface::contains`] for each [`Row::point`], but each triangle near the row is looked
    /// at once, and points are asked about only next to where the surface passes.
    pub fn fill_row(&self, row: &Row, inside: &mut [bool], scratch: &mut RowScratch) {
        let Some(last) = inside.len().checked_sub(1) else { return };
        scratch.passed.clear();
        scratch.passed.resize(inside.len(), false);
        self.mark_passed(row, last, &mut scratch.passed);
        inside[0] = self.contains(row.start);
        for i in 1..=last {
            let passed = scratch.passed[i];
            inside[i] = if passed { self.contains(row.point(i)) } else { inside[i - 1] };
        }
    }

    /// Marks each point between which and the one before the surface may pass. Errs on the safe
    /// side.
    fn mark_passed(&self, row: &Row, last: usize, passed: &mut [bool]) {
        let end = row.point(last);
        let magnitude = Bounds::of([row.start, end]).union(&self.bounds()).magnitude();
        // Points are off the line by their rounding, and so are distances from planes.
        let margin = 64.0 * f64::EPSILON * magnitude;
        let segment = Segment::new(row.start, end);
        let near = |b: &Bounds| segment.span(&b.grown(margin)).is_some();
        self.tree.walk(near, |_, corners| {
            let bounds = Bounds::of(*corners).grown(margin);
            let span = segment.span(&bounds);
            let part = span.and_then(|span| near_plane(corners, row.start, end, span, margin));
            if let Some((first, until)) = part {
                // Points are numbered along the segment; one to each side covers rounding.
                let from = (first * last as f64).floor() as usize;
                let to = (until * last as f64).ceil() as usize + 1;
                passed[from.min(last)..=to.min(last)].fill(true);
            }
            Walk::On
        });
    }
}

/// The part of a span of the segment `from .. to` in which it may be on a triangle's plane.
fn near_plane(
    [a, b, c]: &Corners,
    from: Vec3,
    to: Vec3,
    (first, last): (f64, f64),
    margin: f64,
) -> Option<(f64, f64)> {
    let (ab, ac) = (*b - *a, *c - *a);
    let normal = ab.cross(&ac);
    let long = |v: Vec3| v[0].abs() + v[1].abs() + v[2].abs();
    // What rounding can do to the normal, over the triangle's size, and to a point.
    let slack = margin * (long(normal) + 2.0 * long(ab) * long(ac));
    let (start, end) = ((from - *a).dot(&normal), (to - *a).dot(&normal));
    let slope = end - start;
    let (low, high) = ((-slack - start) / slope, (slack - start) / slope);
    let (low, high) = (low.min(high), low.max(high));
    if !(low.is_finite() && high.is_finite()) {
        return Some((first, last));
    }
    // The quotients' own rounding.
    let wide = 8.0 * f64::EPSILON * low.abs().max(high.abs());
    let part = (first.max(low - wide), last.min(high + wide));
    (part.0 <= part.1).then_some(part)
}
