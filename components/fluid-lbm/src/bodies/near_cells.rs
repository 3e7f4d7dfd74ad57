//! The cells around a sphere, row by row: which of them are stored, and their numbers.
//!
//! Links of a sphere begin and end here. A row is a word with a bit for each cell, so that a shift
//! and a few bit operations find all links of a direction in it. It is read from the lattice's
//! tables when the sphere's first cell is another one; which cells are covered is noted when that
//! has changed.

use crate::bodies::sphere_raster::{RowSpans, Span};
use crate::lattice::d3q19::C;
use crate::lattice::layout::Layout;
use tremie_fluid_kit::cells::grid::{Grid, Side};

/// Cells of a window at most: with one more on either side they fill a word.
const WINDOW: i32 = 62;

/// Some cells along x in every row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first, as seen from the sphere.
    pub first: i32,
    /// Number of cells; all of them in the box, or all beyond the same periodic face.
    pub count: i32,
}

/// Cells of a row in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stored {
    /// Stored cells: bit `k + 1` for cell `k` of the window, the first and the last bit for its
    /// neighbours, also through faces and mirrors.
    pub ends: u64,
    /// The same for the window alone, bit `k` for cell `k`.
    pub cells: u64,
    /// Those of these from which links end at thin solids between cells.
    pub at_sheets: u64,
    /// Number of the first of these.
    pub number: u32,
}

/// A row in a window from which links to the sphere can begin, with all that finding them takes.
#[derive(Clone, Copy, Debug)]
pub struct Near {
    /// See [`Stored`].
    pub cells: u64,
    /// See [`Stored`].
    pub at_sheets: u64,
    /// Cells of the window that the sphere does not cover, stored or not.
    pub free: u64,
    /// See [`Stored`].
    pub number: u32,
    /// Number of the window.
    pub window: u32,
    /// Row of the shell, along y and along z.
    pub row: [i32; 2],
}

/// The cells around a sphere.
#[derive(Clone, Debug, Default)]
pub struct NearCells {
    /// The first, as seen from the sphere; none before the first fit.
    origin: Option<[i32; 3]>,
    /// Along each axis.
    side: i32,
    windows: Vec<Window>,
    /// Rows along y, then along z, then windows.
    rows: Vec<Stored>,
    /// Those cells of each row that are stored and covered, as [`Stored::ends`] has them; with a
    /// row more on either side, which mirrors may fill.
    covered: Vec<u64>,
    near: Vec<Near>,
    /// Number of times that covered cells were noted.
    fits: u64,
}

impl NearCells {
    /// Of `side` cells along each axis of a box.
    pub fn new(grid: &Grid, side: i32) -> Self {
        // Faces cut where the axis wraps around: every `n` cells, wherever the first cell is.
        let cuts = if grid.periodic[0] { side / grid.n[0] + 1 } else { 0 };
        let windows = (side / WINDOW + 1 + cuts) as usize;
        let rows = |side: i32| windows * (side * side) as usize;
        Self {
            origin: None,
            side,
            windows: Vec::with_capacity(windows),
            rows: Vec::with_capacity(rows(side)),
            covered: Vec::with_capacity(rows(side + 2)),
            near: Vec::with_capacity(rows(side)),
            fits: 0,
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

    /// Takes note of the cells that the sphere covers.
    pub fn cover(&mut self, grid: &Grid, sphere: &RowSpans) {
        self.fits += 1;
        let (windows, side) = (self.windows.len(), self.side);
        self.covered.clear();
        for w in 0..windows {
            // A row more on either side: `around` looks at the rows beside each.
            for k in -1..=side {
                for j in -1..=side {
                    let [y, z] = self.coordinates([j, k]);
                    let (y, z) = (grid.fold(1, y).0, grid.fold(2, z).0);
                    let span = ends_in(grid, self.windows[w], sphere.at(y, z));
                    self.covered.push(if span == 0 { 0 } else { self.at(w, y, z).ends & span });
                }
            }
        }
        self.near.clear();
        for k in 0..side {
            for j in 0..side {
                let [y, z] = self.coordinates([j, k]);
                if !grid.contains([0, grid.wrap(1, y), grid.wrap(2, z)]) {
                    continue;
                }
                for (w, &window) in self.windows.iter().enumerate() {
                    let Stored { cells, at_sheets, number, .. } = self.at(w, y, z);
                    // Shifted, because the first bit is that of the neighbour before the window.
                    let free = !(ends_in(grid, window, sphere.at(y, z)) >> 1);
                    let free = free & (u64::MAX >> (64 - window.count));
                    let window = w as u32;
                    let near = Near { cells, at_sheets, free, number, window, row: [j, k] };
                    if self.around(&near).iter().fold(0, |all, ends| all | ends) != 0 {
                        self.near.push(near);
                    }
                }
            }
        }
    }

    /// Number of times that covered cells were noted. While it stays, data on the rows hold.
    #[inline(always)]
    pub fn fits(&self) -> u64 {
        self.fits
    }

    /// The first cell, as seen from the sphere.
    #[inline(always)]
    pub fn origin(&self) -> [i32; 3] {
        self.origin.unwrap_or_default()
    }

    /// Cells along each axis.
    pub fn side(&self) -> i32 {
        self.side
    }

    /// Coordinates `(y, z)` of a row, as seen from the sphere.
    #[inline(always)]
    pub fn coordinates(&self, [j, k]: [i32; 2]) -> [i32; 2] {
        let [_, y, z] = self.origin();
        [y + j, z + k]
    }

    /// The rows in some layers along z from which links can begin, in order.
    pub fn near(&self, layers: std::ops::Range<i32>) -> &[Near] {
        if layers.start <= 0 && layers.end >= self.side {
            return &self.near;
        }
        let before = |layer: i32| self.near.partition_point(|near| near.row[1] < layer);
        &self.near[before(layers.start)..before(layers.end)]
    }

    /// A window.
    #[inline(always)]
    pub fn window(&self, window: u32) -> Window {
        self.windows[window as usize]
    }

    /// Those cells of the nine rows around a row that are stored and covered, as [`Stored::ends`]
    /// has them; the row itself is in their middle, y runs fastest.
    #[inline(always)]
    pub fn around(&self, near: &Near) -> [u64; 9] {
        let Near { window, row: [j, k], .. } = *near;
        let side = self.side + 2;
        let first = ((window as i32 * side + k) * side + j) as usize;
        let side = side as usize;
        let rows = &self.covered[first..first + 2 * side + 3];
        std::array::from_fn(|n| rows[n / 3 * side + n % 3])
    }

    /// Place of the row to which links of a direction lead, among those.
    #[inline(always)]
    pub fn to(i: usize) -> usize {
        ((C[i][2] + 1) * 3 + C[i][1] + 1) as usize
    }

    /// Memory that it takes [bytes].
    pub fn bytes(&self) -> usize {
        size_of::<Stored>() * self.rows.capacity()
            + size_of::<u64>() * self.covered.capacity()
            + size_of::<Near>() * self.near.capacity()
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

    /// Stored cells of a row `(y, z)` in a window; none beyond the shell.
    fn at(&self, window: usize, y: i32, z: i32) -> Stored {
        let [_, first_y, first_z] = self.origin();
        let (j, k, side) = (y - first_y, z - first_z, self.side);
        if j < 0 || k < 0 || j >= side || k >= side {
            return Stored::default();
        }
        self.rows[((window as i32 * side + k) * side + j) as usize]
    }
}

/// Stored cells of a row in a window.
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

/// True for ends of the x axis that are mirrors.
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
    use tremie_fluid_kit::cells::obstacles::Obstacles;

    /// A box with a solid at some of its cells.
    fn layout(sides: [Side; 2], solid: impl Fn([i32; 3]) -> bool) -> Layout {
        let grid = Grid::new([100, 6, 6], [sides, [Side::Wall; 2], [Side::Symmetry; 2]]);
        let solids = (0..grid.len()).map(|k| u16::from(solid(grid.at(k)))).collect();
        let obstacles = Obstacles { solid: solids, sheets: Vec::new() };
        let all = (|_| true, crate::lattice::cell_list::BoundaryId::solid(1));
        Layout::new(grid, &obstacles, 8, |_| false, all).0
    }

    /// Every bit and number is what the layout says of the cell.
    fn check(layout: &Layout, origin: [i32; 3], side: i32) {
        let mut shell = NearCells::new(&layout.grid, side);
        let room = shell.windows.capacity();
        shell.fit(layout, origin);
        assert_eq!(shell.windows.capacity(), room);
        let covered: i32 = shell.windows.iter().map(|window| window.count).sum();
        let (from, to) = (origin[0].max(0), (origin[0] + side).min(100));
        assert_eq!(covered, if layout.grid.periodic[0] { side } else { to - from });
        for (w, window) in shell.windows.iter().enumerate() {
            for z in origin[2]..origin[2] + side {
                for y in origin[1]..origin[1] + side {
                    let row = shell.at(w, y, z);
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
