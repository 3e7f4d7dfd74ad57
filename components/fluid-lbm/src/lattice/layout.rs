//! Box, stored cells and places of populations, together.

use crate::lattice::aa_pattern::{AaPattern, BlockedLinks, Parity};
use crate::lattice::cell_list::CellList;
use crate::lattice::d3q19::{C, OPPOSITE, Q};
use crate::lattice::populations::{Field, Real};
use tremie_fluid_kit::cells::grid::{Grid, Reach, Side};
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Box, stored cells and places of populations.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The box.
    pub grid: Grid,
    /// The cells that no static solid covers.
    pub cells: CellList,
    /// Places of their populations.
    pub places: AaPattern,
    /// Stored cells from which links end at thin solids between cells, sorted.
    at_sheets: Vec<u32>,
}

impl Layout {
    /// Of a box with static solids, in lines of `line` cells. `special` says which fixtures' links
    /// are returned one by one instead of being reflected half-way.
    pub fn new(
        grid: Grid,
        obstacles: &Obstacles,
        line: usize,
        special: impl Fn(crate::lattice::cell_list::BoundaryId) -> bool,
    ) -> (Self, BlockedLinks) {
        let cells = CellList::new(&grid, obstacles);
        let (places, survey) = AaPattern::new(&grid, &cells, obstacles, line, special);
        let numbers = obstacles.sheets.iter().map(|sheet| cells.number(sheet.cell as usize));
        let mut at_sheets: Vec<_> = numbers.collect();
        at_sheets.dedup();
        (Self { grid, cells, places, at_sheets }, survey)
    }

    /// A box without solids.
    #[cfg(test)]
    pub fn open(grid: Grid) -> Self {
        Self::new(grid, &Obstacles::default(), 8, |_| false).0
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

/// Stored cells that share a face with a cell.
pub fn faces(layout: &Layout, cell: u32) -> impl Iterator<Item = u32> {
    let straight = (1..Q).filter(|&i| C[i].iter().map(|c| c.abs()).sum::<i32>() == 1);
    straight.filter_map(move |i| layout.neighbour(cell, i)).filter(move |&n| n != cell)
}
