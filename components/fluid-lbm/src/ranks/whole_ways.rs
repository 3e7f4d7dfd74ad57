//! The ways between all cells of the whole lattice, as every rank has them for a moment: for what has to be found by
//! way of the fluid, however far.

use crate::lattice::cell_list::{BoundaryId, CellList};
use crate::lattice::d3q19::C;
use crate::lattice::layout::{Layout, straight};
use crate::lattice::whole_numbers::WholeNumbers;
use crate::ranks::rank_sums::Ranks;
use tremie_fluid_kit::cells::grid::{Grid, Reach};
use tremie_fluid_kit::cells::obstacles::Obstacles;

/// Place of the order of a cell in its byte; the bits before it say through which faces ways lead.
const ORDER: u32 = 6;

/// All cells, and the ways through their faces.
pub struct WholeWays<'g> {
    grid: &'g Grid,
    cells: CellList,
    /// Of each cell.
    bytes: Vec<u8>,
}

impl<'g> WholeWays<'g> {
    /// Put together from what each rank knows of its cells; `order` is a number less than 4.
    pub fn gather(
        layout: &'g Layout,
        order: impl Fn(u32) -> u8,
        (numbers, obstacles, ranks): (&WholeNumbers, &Obstacles, &Ranks),
    ) -> Self {
        let byte = |cell: u32| {
            let is_way =
                |&(_, i): &(u32, usize)| layout.neighbour(cell, i).is_some_and(|next| next != cell);
            let ways = (0..).zip(straight()).filter(is_way).fold(0, |bits, (k, _)| bits | 1 << k);
            ways | order(cell) << ORDER
        };
        let own: Vec<u8> = layout.own.clone().map(byte).collect();
        let bytes = ranks.gather_to_all(&own);
        let all = (|_| true, BoundaryId::solid(0));
        let cells = CellList::new(&layout.grid, obstacles, all);
        debug_assert_eq!(bytes.len(), numbers.rows_of(1).all);
        Self { grid: &layout.grid, cells, bytes }
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// The order of a cell.
    pub fn order(&self, cell: u32) -> u8 {
        self.bytes[cell as usize] >> ORDER
    }

    /// Visits the cells that share a face with a cell, in the order of directions.
    pub fn faces(&self, cell: u32, visit: &mut dyn FnMut(u32)) {
        let at = self.cells.coordinates(self.grid, cell);
        for (k, i) in (0..).zip(straight()) {
            let next = std::array::from_fn(|a| at[a] + C[i][a]);
            if self.bytes[cell as usize] >> k & 1 == 1
                && let Reach::Cell { at, .. } = self.grid.reach(next)
                && let Some(next) = self.cells.at(self.grid, at)
            {
                visit(next);
            }
        }
    }
}
