//! Box, stored cells and places of populations, together.

use crate::lattice::aa_pattern::{AaPattern, BlockedLinks, Parity};
use crate::lattice::cell_list::{BoundaryId, CellList};
use crate::lattice::d3q19::{C, OPPOSITE, Q};
use crate::lattice::populations::{Field, Real};
use std::ops::Range;
use tremie_fluid_kit::cells::grid::{Grid, Reach, Side};
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Cells of a block: consecutive ones, which collide as one item of work and belong to one rank. What is added up
/// within a block is so in one order, whoever computes it.
pub const CELLS_PER_BLOCK: u32 = 4096;

/// Block of a cell.
#[inline(always)]
pub fn block_of(cell: u32) -> u32 {
    cell / CELLS_PER_BLOCK
}

/// Pieces of a list of cells that may be items of work: `most` cells at most, all of one block.
pub fn items_in_blocks(cells: &[u32], most: usize) -> impl Iterator<Item = Range<usize>> {
    let mut first = 0;
    std::iter::from_fn(move || {
        let rest = cells.get(first..).filter(|rest| !rest.is_empty())?;
        let block = block_of(rest[0]);
        let count = rest.iter().take(most).take_while(|&&cell| block_of(cell) == block).count();
        first += count;
        Some(first - count..first)
    })
}

/// Box, stored cells and places of populations.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The box.
    pub grid: Grid,
    /// The cells that no static solid covers.
    pub cells: CellList,
    /// Places of their populations.
    pub places: AaPattern,
    /// The cells that this part of the lattice counts: all of them, unless others compute parts of it. The rest
    /// are copies of cells that others count.
    pub own: Range<u32>,
    /// Stored cells from which links end at thin solids between cells, sorted.
    at_sheets: Vec<u32>,
}

impl Layout {
    /// Of a box with static solids, in lines of `line` cells. `special` says which fixtures' links
    /// are returned one by one instead of being reflected half-way; `held` which cells are stored, see
    /// [`CellList::new`].
    pub fn new(
        grid: Grid,
        obstacles: &Obstacles,
        line: usize,
        special: impl Fn(BoundaryId) -> bool,
        held: (impl Fn(u32) -> bool, BoundaryId),
    ) -> (Self, BlockedLinks) {
        let cells = CellList::new(&grid, obstacles, held);
        let (places, survey) = AaPattern::new(&grid, &cells, obstacles, line, special);
        let numbers = obstacles.sheets.iter().map(|sheet| cells.number(sheet.cell as usize));
        let mut at_sheets: Vec<_> = numbers.collect();
        at_sheets.dedup();
        let own = 0..cells.len() as u32;
        (Self { grid, cells, places, own, at_sheets }, survey)
    }

    /// A box without solids.
    #[cfg(test)]
    pub fn open(grid: Grid) -> Self {
        let all = (|_| true, BoundaryId::solid(0));
        Self::new(grid, &Obstacles::default(), 8, |_| false, all).0
    }

    /// True if this part of the lattice counts a cell; see [`Layout::own`].
    #[inline(always)]
    pub fn is_own(&self, cell: u32) -> bool {
        cell.wrapping_sub(self.own.start) < self.own.end - self.own.start
    }

    /// Numbers of the blocks of these cells.
    pub fn own_blocks(&self) -> Range<usize> {
        let end = self.own.end.div_ceil(CELLS_PER_BLOCK) as usize;
        block_of(self.own.start) as usize..end
    }

    /// Number of a cell of the box, if it is stored.
    #[inline]
    pub fn cell(&self, at: [i32; 3]) -> Option<u32> {
        self.cells.at(&self.grid, at)
    }

    /// True if a link from a stored cell ends at a thin solid between cells.
    pub fn is_at_sheet(&self, cell: u32) -> bool {
        self.at_sheets.binary_search(&cell).is_ok()
    }

    /// Coordinates of a stored cell.
    #[inline]
    pub fn at(&self, cell: u32) -> [i32; 3] {
        self.cells.coordinates(&self.grid, cell)
    }

    /// Place at which the collision of a parity reads `f_i` of a cell. It leaves `g_i` in the place
    /// of the opposite direction.
    #[inline(always)]
    pub fn place(&self, parity: Parity, cell: u32, i: usize) -> usize {
        self.places.of(parity, cell, i)
    }

    /// The populations `f_i` that the collision of a parity finds in a cell.
    #[inline(always)]
    pub fn populations<T: Real>(&self, field: &Field<T>, parity: Parity, cell: u32) -> [f64; Q] {
        self.places.of_cell(parity, cell).map(|place| field.get(place))
    }

    /// The stored cell at `d` cells from `at`, through periodic faces and mirrors, and the axes at
    /// which the way was mirrored.
    pub fn near(&self, at: [i32; 3], d: [i32; 3]) -> Option<(u32, u8)> {
        match self.grid.reach(std::array::from_fn(|a| at[a] + d[a])) {
            Reach::Cell { at, mirrors } if self.grid.contains(at) => {
                self.cell(at).map(|cell| (cell, mirrors))
            }
            _ => None,
        }
    }

    /// The cell to which the link along `i` leads, if it ends in a stored cell.
    #[inline]
    pub fn neighbour(&self, cell: u32, i: usize) -> Option<u32> {
        self.places.neighbour(cell, i)
    }

    /// The cell behind a link's beginning, against its direction `i`, if there is one: the cell
    /// itself where it sees itself in a mirror.
    #[inline]
    pub fn behind(&self, cell: u32, i: usize) -> Option<u32> {
        let back = OPPOSITE[i];
        self.neighbour(cell, back).or_else(|| self.sees_itself(cell, back).then_some(cell))
    }

    /// True if the link along `i` leads straight into a mirror, and so back to the cell itself.
    pub fn sees_itself(&self, cell: u32, i: usize) -> bool {
        let at = self.at(cell);
        (0..3).all(|a| match C[i][a] {
            0 => true,
            c => {
                let side = usize::from(c > 0);
                C[i].iter().map(|c| c.abs()).sum::<i32>() == 1
                    && self.grid.sides[a][side] == Side::Symmetry
                    && at[a] == [0, self.grid.n[a] - 1][side]
            }
        })
    }
}

/// The directions along axes.
pub fn straight() -> impl Iterator<Item = usize> {
    (1..Q).filter(|&i| C[i].iter().map(|c| c.abs()).sum::<i32>() == 1)
}

/// Stored cells that share a face with a cell.
pub fn faces(layout: &Layout, cell: u32) -> impl Iterator<Item = u32> {
    straight().filter_map(move |i| layout.neighbour(cell, i)).filter(move |&n| n != cell)
}
