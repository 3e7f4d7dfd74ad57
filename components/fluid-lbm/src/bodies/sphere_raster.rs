//! Cells that a sphere covers, and the intersection of a link with its surface.
//!
//! Both answers come from the same comparison, `inside`, so that a link that ends inside the
//! sphere and begins outside always has its wall at `0 < q <= 1`. Lengths in cells.

use tremie_fluid_kit::cells::grid::Grid;

/// True if a point at `d` from the centre belongs to a sphere of squared radius `r2`. Its surface
/// belongs to it.
#[inline]
pub fn inside(d: [f64; 3], r2: f64) -> bool {
    d[0] * d[0] + (d[1] * d[1] + d[2] * d[2]) <= r2
}

/// Fraction `q` of the link from `d` (outside, seen from the centre) along `c` at which it meets
/// the sphere, in `(0, 1]`, given that `d + c` is inside.
///
/// The smaller root of `|d + q c|^2 = r2` in the form that does not cancel near the surface.
#[inline]
pub fn wall_distance(d: [f64; 3], c: [f64; 3], r2: f64) -> f64 {
    let aa = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
    let b = d[0] * c[0] + d[1] * c[1] + d[2] * c[2];
    let gap = (d[0] * d[0] + (d[1] * d[1] + d[2] * d[2])) - r2;
    let root = (b * b - aa * gap).max(0.0).sqrt();
    // `gap > 0` exactly, because `inside(d)` is false. Rounding alone can push q out of its range.
    (gap / (root - b)).clamp(f64::MIN_POSITIVE, 1.0)
}

/// First and last cell of a row inside a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// First cell inside.
    pub first: i32,
    /// Last cell inside; before `first` if the row misses the body.
    pub last: i32,
}

impl Span {
    /// No cell.
    pub const NONE: Self = Self { first: 0, last: -1 };

    /// True if the row misses the body.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.last < self.first
    }

    /// True if cell `x` is inside.
    #[inline]
    pub fn contains(self, x: i32) -> bool {
        self.first <= x && x <= self.last
    }

    /// Calls `visit` for each cell of this span that is not in `other`.
    fn minus(self, other: Self, mut visit: impl FnMut(i32)) {
        let (until, from) = if other.is_empty() {
            (self.last, self.last + 1)
        } else {
            (other.first - 1, other.last + 1)
        };
        for x in self.first..=self.last.min(until) {
            visit(x);
        }
        for x in self.first.max(from)..=self.last {
            visit(x);
        }
    }
}

/// The cells inside a body, row by row. Coordinates may lie outside the box along periodic axes;
/// along walled axes the body is cut off at the faces.
#[derive(Clone, Debug)]
pub struct RowSpans {
    /// Coordinates `(y, z)` of the first row.
    origin: [i32; 2],
    /// Rows along y and along z.
    side: i32,
    rows: Vec<Span>,
    /// Centre of the sphere when they were found, and the largest shift from there, in any
    /// direction, at which it still covers the same cells.
    centre: [f64; 3],
    slack: f64,
}

/// Slack of a sphere at most: a row beyond [`RowSpans::side`] is half a cell away from it, and
/// more.
const MOST_SLACK: f64 = 0.4;

/// By how much the squared distance of a cell to the centre of a sphere differs from the squared
/// radius: the least of those inside, and of those outside.
#[derive(Clone, Copy)]
struct Margins {
    inside: f64,
    outside: f64,
}

impl Margins {
    /// Takes note of a cell at `d` from the centre.
    #[inline(always)]
    fn note(&mut self, d: [f64; 3], r2: f64) {
        let deep = r2 - (d[0] * d[0] + (d[1] * d[1] + d[2] * d[2]));
        if deep >= 0.0 {
            self.inside = self.inside.min(deep);
        } else {
            self.outside = self.outside.min(-deep);
        }
    }

    /// The least distance from a cell to the surface, or [`MOST_SLACK`]; less what rounding may
    /// make of it.
    fn slack(self, radius: f64) -> f64 {
        // |d| - r is the difference of the squares over |d| + r.
        let inside = self.inside / (2.0 * radius);
        let outside = self.outside / (2.0 * radius + MOST_SLACK);
        inside.min(outside).min(MOST_SLACK) - 1e-9
    }
}

impl RowSpans {
    /// Of no cell, with room for a sphere of the given radius.
    pub fn empty(radius: f64) -> Self {
        let side = (2.0 * radius).ceil() as i32 + 2;
        let rows = vec![Span::NONE; (side * side) as usize];
        Self { origin: [0, 0], side, rows, centre: [0.0; 3], slack: 0.0 }
    }

    /// Becomes the cells inside the sphere; none if it is beyond a wall. The radius is at most that
    /// of [`RowSpans::empty`].
    pub fn fit(&mut self, grid: &Grid, centre: [f64; 3], radius: f64) {
        let beyond =
            |a: usize| centre[a] + radius < 0.0 || centre[a] - radius > f64::from(grid.n[a]);
        if (0..3).any(|a| !grid.periodic[a] && beyond(a)) {
            return self.clear();
        }
        let r2 = radius * radius;
        self.origin = [1, 2].map(|a| (centre[a] - radius).floor() as i32);
        let mut margins = Margins { inside: f64::INFINITY, outside: f64::INFINITY };
        for k in 0..self.rows.len() as i32 {
            let (y, z) = (self.origin[0] + k % self.side, self.origin[1] + k / self.side);
            self.rows[k as usize] = span_of(grid, centre, radius, r2, [y, z], &mut margins);
        }
        (self.centre, self.slack) = (centre, margins.slack(radius));
    }

    /// True if the sphere covers the same cells at another place near by.
    #[inline]
    pub fn hold_at(&self, centre: [f64; 3]) -> bool {
        let by: [f64; 3] = std::array::from_fn(|a| centre[a] - self.centre[a]);
        let far2 = by[0] * by[0] + (by[1] * by[1] + by[2] * by[2]);
        self.slack > 0.0 && far2 < self.slack * self.slack
    }

    /// Place of a sphere at which they were found, given where it is now.
    pub fn found_at(&self, now: [f64; 3]) -> [f64; 3] {
        // Without slack they are found anew wherever it goes.
        if self.slack > 0.0 { self.centre } else { now }
    }

    /// Moves all coordinates.
    pub fn shift(&mut self, by: [i32; 3]) {
        self.slack = 0.0;
        self.origin = [self.origin[0] + by[1], self.origin[1] + by[2]];
        for span in &mut self.rows {
            *span = Span { first: span.first + by[0], last: span.last + by[0] };
        }
    }

    /// Becomes empty.
    pub fn clear(&mut self) {
        self.slack = 0.0;
        self.rows.fill(Span::NONE);
    }

    /// Cells of the row `(y, z)` inside.
    #[inline]
    pub fn at(&self, y: i32, z: i32) -> Span {
        let (j, k) = (y - self.origin[0], z - self.origin[1]);
        if j < 0 || k < 0 || j >= self.side || k >= self.side {
            return Span::NONE;
        }
        self.rows[(j + k * self.side) as usize]
    }

    /// Rows along y or z, one more than the body on either side: where links to it can begin.
    pub fn shell_side(&self) -> i32 {
        self.side + 2
    }

    /// Coordinates `(y, z)` of row `(j, k)` of the shell, `0 <= j, k < shell_side()`.
    pub fn shell_row(&self, j: i32, k: i32) -> [i32; 2] {
        [self.origin[0] - 1 + j, self.origin[1] - 1 + k]
    }

    /// True if these are the same cells in the same rows.
    #[inline]
    pub fn are(&self, other: &Self) -> bool {
        (self.origin, &self.rows) == (other.origin, &other.rows)
    }

    /// Calls `visit` with the coordinates of each cell that is inside, but not inside `other`.
    pub fn minus(&self, other: &Self, mut visit: impl FnMut([i32; 3])) {
        for (k, span) in (0..).zip(&self.rows) {
            if !span.is_empty() {
                let (y, z) = (self.origin[0] + k % self.side, self.origin[1] + k / self.side);
                span.minus(other.at(y, z), |x| visit([x, y, z]));
            }
        }
    }
}

/// Cells of the row `(y, z)` inside the sphere, cut off at walls; notes those on either side of its
/// surface.
fn span_of(
    grid: &Grid,
    centre: [f64; 3],
    radius: f64,
    r2: f64,
    [y, z]: [i32; 2],
    margins: &mut Margins,
) -> Span {
    let outside = |axis: usize, k: i32| !grid.periodic[axis] && (k < 0 || k >= grid.n[axis]);
    if outside(1, y) || outside(2, z) {
        return Span::NONE;
    }
    let (dy, dz) = (f64::from(y) + 0.5 - centre[1], f64::from(z) + 0.5 - centre[2]);
    let arm = |x: i32| [f64::from(x) + 0.5 - centre[0], dy, dz];
    let inside = |x: i32| inside(arm(x), r2);
    let half = (radius * radius - (dy * dy + dz * dz)).max(0.0).sqrt();
    // An estimate to within rounding, then the comparison that decides.
    let mut first = (centre[0] - half - 0.5) as i32;
    let mut last = (centre[0] + half - 0.5) as i32;
    while inside(first - 1) {
        first -= 1;
    }
    while first <= last && !inside(first) {
        first += 1;
    }
    while inside(last + 1) {
        last += 1;
    }
    while first <= last && !inside(last) {
        last -= 1;
    }
    // In a row without a cell inside, the two next to the centre are among the four around `last`.
    let ends = if last < first { [last - 1, last + 2] } else { [first, last] };
    for x in [ends[0] - 1, ends[0], ends[1], ends[1] + 1, first, last] {
        margins.note(arm(x), r2);
    }
    if !grid.periodic[0] {
        (first, last) = (first.max(0), last.min(grid.n[0] - 1));
    }
    if last < first { Span::NONE } else { Span { first, last } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::d3q19::{C, C_F64, Q};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spans_hold_exactly_the_cells_inside(
            centre in prop::array::uniform3(4.0..8.0_f64), radius in 0.1..4.0_f64,
        ) {
            let grid = Grid::walled([12, 12, 12], [true; 3]);
            let mut spans = RowSpans::empty(radius);
            spans.fit(&grid, centre, radius);
            for z in -1..13 {
                for y in -1..13 {
                    for x in -1..13 {
                        let d = [x, y, z].map(|k| f64::from(k) + 0.5);
                        let d = std::array::from_fn(|a| d[a] - centre[a]);
                        prop_assert_eq!(spans.at(y, z).contains(x), inside(d, radius * radius));
                    }
                }
            }
        }

        #[test]
        fn a_sphere_covers_the_same_cells_as_far_as_its_slack_says(
            centre in prop::array::uniform3(-2.0..14.0_f64), radius in 0.1..4.0_f64,
            by in prop::array::uniform3(-0.15..0.15_f64), scale in 0.0..1.0_f64,
        ) {
            let grid = Grid::walled([12, 12, 12], [true, true, false]);
            let mut before = RowSpans::empty(radius);
            before.fit(&grid, centre, radius);
            // Small steps too, or hardly any would be within the slack.
            let moved = std::array::from_fn(|a| centre[a] + scale * scale * scale * by[a]);
            let mut after = RowSpans::empty(radius);
            after.fit(&grid, moved, radius);
            if before.hold_at(moved) {
                for (y, z) in (-8..20).flat_map(|y| (-8..20).map(move |z| (y, z))) {
                    prop_assert_eq!(before.at(y, z), after.at(y, z));
                }
            }
            prop_assert!(before.slack <= 0.0 || before.hold_at(centre));
        }

        #[test]
        fn every_link_into_a_sphere_meets_it_between_its_ends(
            centre in prop::array::uniform3(4.0..8.0_f64), radius in 0.3..4.0_f64,
        ) {
            let r2 = radius * radius;
            for k in 0..12_i32.pow(3) {
                let at = [k % 12, k / 12 % 12, k / 144];
                let d: [f64; 3] = std::array::from_fn(|a| f64::from(at[a]) + 0.5 - centre[a]);
                for i in 1..Q {
                    let end: [f64; 3] =
                        std::array::from_fn(|a| f64::from(at[a] + C[i][a]) + 0.5 - centre[a]);
                    if !inside(d, r2) && inside(end, r2) {
                        let q = wall_distance(d, C_F64[i], r2);
                        prop_assert!(q > 0.0 && q <= 1.0);
                        let wall: f64 = (0..3).map(|a| (d[a] + q * C_F64[i][a]).powi(2)).sum();
                        prop_assert!((wall.sqrt() - radius).abs() < 1e-7, "{} {}", wall.sqrt(), radius);
                    }
                }
            }
        }
    }
}
