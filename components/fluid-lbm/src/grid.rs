//! The box of cells: shape, indices, neighbours.
//!
//! Cells lie in rows along x. A row takes a whole number of vectors plus one more, so that each row
//! begins at a vector's boundary and cells `-1` and `n` exist in memory on either side. Along a
//! walled axis one layer of ghost rows lies beyond each face; a periodic axis wraps to its other
//! end.

use crate::lattice::{C, OPPOSITE, Q};

/// Rows are padded to this many cells: the longest vector (64 bytes) of the shorter number (f32).
pub const PAD: usize = 16;

/// A cell: coordinates and place in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Coordinates; `-1` or `n` along a walled axis for a ghost.
    pub at: [i32; 3],
    /// Place within an array over the grid.
    pub index: usize,
    /// Whether no neighbour is on the far side of a periodic face.
    pub inner: bool,
}

/// Shape of the box.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cells along each axis.
    pub n: [i32; 3],
    /// Which axes wrap around.
    pub periodic: [bool; 3],
    /// Cells from one row to the next.
    pub stride: usize,
    /// Ghost rows before the first row, along y and z.
    ghosts: [i32; 2],
    /// Rows along y, ghosts included.
    rows_y: usize,
    /// Cells of an array over the grid, padding included.
    pub len: usize,
    /// Distance in memory to the neighbour in each direction, away from periodic faces.
    offset: [isize; Q],
}

impl Grid {
    /// A box of `n` cells.
    pub fn new(n: [usize; 3], periodic: [bool; 3]) -> Self {
        let ghosts = [i32::from(!periodic[1]), i32::from(!periodic[2])];
        let stride = n[0].next_multiple_of(PAD) + PAD;
        let rows_y = n[1] + 2 * ghosts[0] as usize;
        let len = Self::padded_len(n, periodic).expect("a grid that was resolved fits in memory");
        let offset = std::array::from_fn(|i| {
            C[i][0] as isize
                + C[i][1] as isize * stride as isize
                + C[i][2] as isize * (stride * rows_y) as isize
        });
        Self { n: n.map(|n| n as i32), periodic, stride, ghosts, rows_y, len, offset }
    }

    /// Cells of an array over a box of `n` cells, padding included; `None` if there are more than
    /// can be indexed.
    pub fn padded_len(n: [usize; 3], periodic: [bool; 3]) -> Option<usize> {
        let ghosts = |axis: usize| if periodic[axis] { 0 } else { 2 };
        let stride = n[0].checked_next_multiple_of(PAD)?.checked_add(PAD)?;
        let rows = n[1].checked_add(ghosts(1))?.checked_mul(n[2].checked_add(ghosts(2))?)?;
        let len = rows.checked_mul(stride)?.checked_add(PAD)?;
        u32::try_from(len).ok().map(|len| len as usize)
    }

    /// Number of rows of the box, ghosts not counted.
    pub fn rows(&self) -> usize {
        (self.n[1] * self.n[2]) as usize
    }

    /// Coordinates `(y, z)` of a row of the box.
    pub fn row_at(&self, row: usize) -> [i32; 2] {
        let ny = self.n[1] as usize;
        [(row % ny) as i32, (row / ny) as i32]
    }

    /// Index of cell `x = 0` of row `(y, z)`, ghost rows included.
    #[inline]
    pub fn row_start(&self, y: i32, z: i32) -> usize {
        let row = (y + self.ghosts[0]) as usize + self.rows_y * (z + self.ghosts[1]) as usize;
        PAD + row * self.stride
    }

    /// Index of a cell or ghost.
    #[inline]
    pub fn index(&self, at: [i32; 3]) -> usize {
        (self.row_start(at[1], at[2]) as isize + at[0] as isize) as usize
    }

    /// Coordinate moved to the box along a periodic axis, unchanged along a walled one.
    #[inline]
    pub fn wrap(&self, axis: usize, k: i32) -> i32 {
        if self.periodic[axis] && (k < 0 || k >= self.n[axis]) {
            k.rem_euclid(self.n[axis])
        } else {
            k
        }
    }

    /// The cell at coordinates of the box.
    #[inline]
    pub fn cell(&self, at: [i32; 3]) -> Cell {
        let inner = (0..3).all(|a| !self.periodic[a] || (at[a] > 0 && at[a] < self.n[a] - 1));
        Cell { at, index: self.index(at), inner }
    }

    /// The cell of an index that belongs to the box.
    pub fn cell_of(&self, index: usize) -> Cell {
        let index = index - PAD;
        let (row, x) = (index / self.stride, index % self.stride);
        let y = (row % self.rows_y) as i32 - self.ghosts[0];
        let z = (row / self.rows_y) as i32 - self.ghosts[1];
        self.cell([x as i32, y, z])
    }

    /// Coordinates of the neighbour of `at` in direction `i`; a ghost beyond a wall.
    #[inline]
    pub fn neighbour_at(&self, at: [i32; 3], i: usize) -> [i32; 3] {
        std::array::from_fn(|a| self.wrap(a, at[a] + C[i][a]))
    }

    /// Index of the neighbour of `cell` in direction `i`; a ghost's beyond a wall.
    #[inline]
    pub fn neighbour(&self, cell: Cell, i: usize) -> usize {
        if cell.inner {
            (cell.index as isize + self.offset[i]) as usize
        } else {
            self.index(self.neighbour_at(cell.at, i))
        }
    }

    /// Whether the cell lies in the box (and is no ghost).
    #[inline]
    pub fn contains(&self, at: [i32; 3]) -> bool {
        (0..3).all(|a| at[a] >= 0 && at[a] < self.n[a])
    }

    /// A position [cells] moved into the box along periodic axes.
    pub fn canonical(&self, position: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            let n = f64::from(self.n[a]);
            if !self.periodic[a] {
                return position[a];
            }
            let wrapped = position[a] - n * (position[a] / n).floor();
            // Rounding can leave `n` itself.
            if wrapped < n { wrapped } else { 0.0 }
        })
    }

    /// Vector from `point` to the centre of `at`, through periodic faces where that is shorter
    /// [cells].
    #[inline]
    pub fn arm(&self, point: [f64; 3], at: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            let d = f64::from(at[a]) + 0.5 - point[a];
            if self.periodic[a] {
                let n = f64::from(self.n[a]);
                d - n * (d / n).round()
            } else {
                d
            }
        })
    }
}

/// Which of the two in-place steps is meant (Bailey et al. 2009, pattern "AA").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// Reads and writes within a cell.
    Even,
    /// Reads from and writes to the neighbours.
    Odd,
}

impl Parity {
    /// The other one.
    #[inline]
    pub fn flipped(self) -> Self {
        match self {
            Self::Even => Self::Odd,
            Self::Odd => Self::Even,
        }
    }

    /// Where the collision of this parity finds `f_i` of `cell`: plane and index.
    ///
    /// The same collision leaves `g_i` in the place of the opposite direction, so that after it
    /// `g_i` stands in `place(OPPOSITE[i])`. With `P` the parity of a step, a wall link reads the
    /// post-collision values in places of `P` and writes the reflected one into a place of
    /// `P.flipped()`.
    #[inline(always)]
    pub fn place(self, grid: &Grid, cell: Cell, i: usize) -> (usize, usize) {
        match self {
            Self::Even => (i, cell.index),
            Self::Odd => (OPPOSITE[i], grid.neighbour(cell, OPPOSITE[i])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_place_belongs_to_one_cell_and_direction() {
        for periodic in [[true; 3], [false; 3], [true, false, true], [false, true, false]] {
            let grid = Grid::new([5, 4, 3], periodic);
            for parity in [Parity::Even, Parity::Odd] {
                let mut seen = HashSet::new();
                for row in 0..grid.rows() {
                    let [y, z] = grid.row_at(row);
                    for x in 0..grid.n[0] {
                        let cell = grid.cell([x, y, z]);
                        assert_eq!(grid.cell_of(cell.index), cell);
                        for i in 0..Q {
                            let (plane, index) = parity.place(&grid, cell, i);
                            assert!(index < grid.len);
                            assert!(seen.insert((plane, index)), "{cell:?} {i}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_shortest_way_leads_through_periodic_faces() {
        let grid = Grid::new([10, 10, 10], [true, false, true]);
        let d = grid.arm([9.5, 9.5, 0.5], [0, 0, 9]);
        assert_eq!(d, [1.0, -9.0, -1.0]);
        assert_eq!(grid.canonical([-0.25, -0.25, 10.5]), [9.75, -0.25, 0.5]);
    }
}
