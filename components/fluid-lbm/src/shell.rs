//! The cells around a sphere, row by row: which of them are stored, and their numbers.
//!
//! Links of a sphere begin and end here. A row is a word with a bit for each cell, so that a shift and a few
//! bit operations find all links of a direction in it. It is read from the lattice's tables when the sphere has come to other
//! cells, which it does every fifty steps or so.

use crate::grid::{Grid, Side};
use crate::lattice::C;
use crate::layout::Layout;
use crate::sphere::{Span, Spans};

/// Cells of a window at most: with one more on either side they fill a word.
const WINDOW: i32 = 62;

/// Some cells along x in every row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first, as seen from the sphere.
    pub first: i32,
    /// How many; all of them in the box, or all beyond the same periodic face.
    pub count: i32,
}

/// Cells of a row in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stored {
    /// Which are stored: bit `k + 1` for cell `k` of the window, the first and the last bit for its neighbours, also
    /// through faces and mirrors.
    pub ends: u64,
    /// The same for the window alone, bit `k` for cell `k`.
    pub cells: u64,
    /// Those of these from which links end at thin solids between cells.
    pub at_sheets: u64,
    /// Number of the first of these.
    pub number: u32,
}

/// The cells around a sphere.
#[derive(Clone, Debug, Default)]
pub struct Shell {
    /// The first, as seen from the sphere; none before the first fit.
    origin: Option<[i32; 3]>,
    /// Along each axis.
    side: i32,
    windows: Vec<Window>,
    /// Rows along y, then along z, then windows.
    rows: Vec<Stored>,
}

impl Shell {
    /// Of `side` cells along each axis.
    pub fn new(side: i32) -> Self {
        // One more at a periodic face.
        let windows = side as usize / WINDOW as usize + 2;
        Self {
            origin: None,
            side,
            windows: Vec::with_capacity(windows),
            rows: Vec::with_capacity(windows * (side * side) as usize),
        }
    }

    /// Becomes the cells from `origin` on; true if it was not.
    pub fn fit(&mut self, layout: &Layout, origin: [i32; 3]) -> bool {
        if self.origin.replace(origin) == Some(origin) {
            return false;
        }
        self.cut(&layout.grid, origin[0]);
        self.rows.clear();
        for &window in &self.windows {
            for z in origin[2]..origin[2] + self.side {
                for y in origin[1]..origin[1] + self.side {
                    self.rows.push(stored(layout, window, [y, z]));
                }
            }
        }
        true
    }

    /// Cuts the cells along x into windows.
    fn cut(&mut self, grid: &Grid, first: i32) {
        let (n, mut end) = (grid.n[0], first + self.side);
        let mut next = first;
        if !grid.periodic[0] {
            (next, end) = (first.max(0), end.min(n));
        }
        self.windows.clear();
        while next < end {
            let face = (next.div_euclid(n) + 1) * n;
            let until = end.min(face).min(next + WINDOW);
            self.windows.push(Window { first: next, count: until - next });
            next = until;
        }
    }

    /// The windows.
    #[inline(always)]
    pub fn windows(&self) -> &[Window] {
        &self.windows
    }

    /// What a row `(y, z)` holds in a window; nothing beyond the shell.
    #[inline(always)]
    pub fn row(&self, window: usize, y: i32, z: i32) -> Stored {
        let [_, first_y, first_z] = self.origin.unwrap_or_default();
        let (j, k, side) = (y - first_y, z - first_z, self.side);
        if j < 0 || k < 0 || j >= side || k >= side {
            return Stored::default();
        }
        self.rows[((window as i32 * side + k) * side + j) as usize]
    }
}

/// The nine rows around a row of a sphere's shell, itself in their middle, y running fastest.
pub struct Around {
    rows: [[i32; 2]; 9],
    /// The axes among y and z at which the way to each is mirrored.
    pub mirrors: [u8; 9],
    spans: [Span; 9],
}

impl Around {
    /// Those around `(y, z)`, unless the sphere covers no cell of them.
    #[inline(always)]
    pub fn of(grid: &Grid, sphere: &Spans, [y, z]: [i32; 2]) -> Option<Self> {
        let to_y = [-1, 0, 1].map(|d| grid.fold(1, y + d));
        let to_z = [-1, 0, 1].map(|d| grid.fold(2, z + d));
        let rows: [_; 9] = std::array::from_fn(|n| [to_y[n % 3].0, to_z[n / 3].0]);
        let spans = rows.map(|[y, z]| sphere.at(y, z));
        if spans.iter().all(|span| span.is_empty()) {
            return None;
        }
        let mirrors = std::array::from_fn(|n| to_y[n % 3].1 << 1 | to_z[n / 3].1 << 2);
        Some(Self { rows, mirrors, spans })
    }

    /// Place of the row to which links of a direction lead.
    #[inline(always)]
    pub fn to(i: usize) -> usize {
        ((C[i][2] + 1) * 3 + C[i][1] + 1) as usize
    }

    /// Those cells of each row that are stored and covered, as [`Stored::ends`] has them.
    #[inline(always)]
    pub fn ends(&self, grid: &Grid, shell: &Shell, (w, window): (usize, Window)) -> [u64; 9] {
        std::array::from_fn(|n| {
            let [y, z] = self.rows[n];
            shell.row(w, y, z).ends & ends_in(grid, window, self.spans[n])
        })
    }

    /// Those cells of the window in the middle row that are not covered, stored or not.
    #[inline(always)]
    pub fn outside(&self, grid: &Grid, window: Window) -> u64 {
        !(ends_in(grid, window, self.spans[4]) >> 1) & (u64::MAX >> (64 - window.count))
    }
}

/// What a row holds in a window.
fn stored(layout: &Layout, window: Window, [y, z]: [i32; 2]) -> Stored {
    let grid = &layout.grid;
    let (y, z) = (grid.wrap(1, y), grid.wrap(2, z));
    let mut found = Stored::default();
    if !grid.contains([0, y, z]) {
        return found;
    }
    for bit in 0..window.count + 2 {
        let (x, _) = grid.fold(0, grid.wrap(0, window.first + bit - 1));
        let Some(number) = (x >= 0 && x < grid.n[0]).then(|| layout.cell([x, y, z])).flatten()
        else {
            continue;
        };
        found.ends |= 1 << bit;
        if bit > 0 && bit <= window.count {
            if found.cells == 0 {
                found.number = number;
            }
            found.cells |= 1 << (bit - 1);
            found.at_sheets |= u64::from(layout.is_at_sheet(number)) << (bit - 1);
        }
    }
    found
}

/// Which ends of the x axis are mirrors.
#[inline(always)]
fn mirrors(grid: &Grid) -> [bool; 2] {
    grid.sides[0].map(|side| side == Side::Symmetry)
}

/// The cells of a span, and its image in a mirror next to it, as [`Stored::ends`] has them.
#[inline(always)]
fn ends_in(grid: &Grid, window: Window, span: Span) -> u64 {
    let Span { mut first, mut last } = span;
    if last < first {
        return 0;
    }
    let [lower, upper] = mirrors(grid);
    first -= i32::from(lower && first == 0);
    last += i32::from(upper && last == grid.n[0] - 1);
    bits(first - (window.first - 1), last - (window.first - 1))
}

/// The bits from `first` to `last` of those that there are.
#[inline(always)]
fn bits(first: i32, last: i32) -> u64 {
    let (first, last) = (first.max(0), last.min(63));
    if last < first { 0 } else { u64::MAX >> (63 - (last - first)) << first }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::Obstacles;

    /// A box with a solid at some of its cells.
    fn layout(sides: [Side; 2], solid: impl Fn([i32; 3]) -> bool) -> Layout {
        let grid = Grid::new([100, 6, 6], [sides, [Side::Wall; 2], [Side::Symmetry; 2]]);
        let solids = (0..grid.len()).map(|k| u16::from(solid(grid.at(k)))).collect();
        let obstacles = Obstacles { solid: solids, sheets: Vec::new() };
        Layout::new(grid, &obstacles, 8, |_| false).0
    }

    /// Every bit and number is what the layout says of the cell.
    fn check(layout: &Layout, origin: [i32; 3], side: i32) {
        let mut shell = Shell::new(side);
        shell.fit(layout, origin);
        let covered: i32 = shell.windows().iter().map(|window| window.count).sum();
        let (from, to) = (origin[0].max(0), (origin[0] + side).min(100));
        assert_eq!(covered, if layout.grid.periodic[0] { side } else { to - from });
        for (w, window) in shell.windows().iter().enumerate() {
            for z in origin[2]..origin[2] + side {
                for y in origin[1]..origin[1] + side {
                    let row = shell.row(w, y, z);
                    let mut numbers = row.number..;
                    for bit in 0..window.count + 2 {
                        let (x, _) = layout.grid.fold(0, window.first + bit - 1);
                        let at = [layout.grid.wrap(0, x), y, z];
                        let cell = layout.grid.contains(at).then(|| layout.cell(at)).flatten();
                        assert_eq!(row.ends >> bit & 1 == 1, cell.is_some(), "{at:?}");
                        if bit > 0 && bit <= window.count {
                            assert_eq!(row.cells >> (bit - 1) & 1 == 1, cell.is_some());
                            assert!(cell.is_none_or(|cell| Some(cell) == numbers.next()));
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn rows_are_those_of_the_lattice_at_faces_mirrors_and_solids() {
        let some = |[x, y, z]: [i32; 3]| (x * 7 + y * 3 + z) % 5 == 0;
        for sides in [[Side::Periodic; 2], [Side::Wall; 2], [Side::Symmetry; 2]] {
            let layout = layout(sides, some);
            for x in [-3, -1, 0, 40, 95, 98] {
                check(&layout, [x, -1, 2], 7);
            }
            check(&layout, [-20, -60, -60], 130);
        }
    }

    #[test]
    fn a_span_at_a_mirror_goes_on_behind_it() {
        let grid = layout([Side::Symmetry; 2], |_| false).grid;
        let window = Window { first: 0, count: 62 };
        assert_eq!(ends_in(&grid, window, Span { first: 0, last: 2 }), 0b1111);
        assert_eq!(ends_in(&grid, window, Span { first: 1, last: 2 }), 0b1100);
        assert_eq!(ends_in(&grid, window, Span::NONE), 0);
        let window = Window { first: 90, count: 10 };
        assert_eq!(ends_in(&grid, window, Span { first: 98, last: 99 }), 0b111 << 9);
        assert_eq!(ends_in(&grid, window, Span { first: 0, last: 99 }), u64::MAX >> (63 - 11));
    }
}
