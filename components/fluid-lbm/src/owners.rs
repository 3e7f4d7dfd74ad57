//! The map of cells: which are fluid, which belong to a wall or to bodies.
//!
//! Bodies move by releasing cells and claiming others, all releases before all claims, one thread,
//! in the order of the bodies. [`Owners::settle`] then says which cells joined the fluid, which
//! left it, and which fluid cells have no fluid neighbour left; those are frozen as solid until a
//! neighbour becomes fluid again.

use crate::grid::Grid;
use crate::lattice::Q;

/// Owner of a cell.
pub type Owner = u32;

/// Nobody: the cell is fluid.
pub const FLUID: Owner = 0;
/// Beyond a wall, or padding.
pub const WALL: Owner = 1;
/// A cell without fluid neighbours.
pub const ISOLATED: Owner = 2;
/// Released in this step and not yet fluid.
pub const VACATED: Owner = 3;
/// More than one body.
pub const SHARED: Owner = 4;
/// The first body; body `h` owns as `BODY + h`.
pub const BODY: Owner = 8;

/// A cell that a body released.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Vacated {
    /// The cell.
    pub cell: u32,
    /// Handle of the body.
    pub handle: u32,
}

/// The map.
#[derive(Clone, Debug)]
pub struct Owners {
    of: Vec<Owner>,
    /// One bit a cell: whether it is fluid.
    fluid: Vec<u8>,
    /// Claims on shared cells, sorted: (cell, handle).
    shared: Vec<(u32, u32)>,
    /// Cells that joined the fluid in this step.
    pub vacated: Vec<Vacated>,
    /// Cells that bodies took from the fluid in this step.
    pub covered: Vec<u32>,
    /// Fluid cells that were left without fluid neighbours in this step.
    pub enclosed: Vec<u32>,
    /// Frozen cells, at the end of the last step.
    pub isolated: usize,
    /// Fluid cells.
    pub fluid_cells: usize,
}

impl Owners {
    /// All cells of the box fluid.
    pub fn new(grid: &Grid) -> Self {
        let mut owners = Self {
            of: vec![WALL; grid.len],
            fluid: vec![0; grid.len.div_ceil(8) + 1],
            shared: Vec::new(),
            vacated: Vec::new(),
            covered: Vec::new(),
            enclosed: Vec::new(),
            isolated: 0,
            fluid_cells: 0,
        };
        for row in 0..grid.rows() {
            let [y, z] = grid.row_at(row);
            for x in 0..grid.n[0] {
                owners.set(grid.index([x, y, z]), FLUID);
            }
        }
        owners
    }

    /// Makes room for the changes of a step in which bodies cover and uncover up to `changes`
    /// cells.
    pub fn reserve(&mut self, changes: usize) {
        for list in [&mut self.covered, &mut self.enclosed] {
            list.reserve(changes.saturating_sub(list.len()));
        }
        self.vacated.reserve(changes.saturating_sub(self.vacated.len()));
        self.shared.reserve(changes.saturating_sub(self.shared.len()));
    }

    /// Owner of a cell.
    #[inline(always)]
    pub fn of(&self, cell: usize) -> Owner {
        self.of[cell]
    }

    /// One bit a cell: whether it is fluid.
    pub fn fluid_bits(&self) -> &[u8] {
        &self.fluid
    }

    /// Handles of the bodies that claim a shared cell.
    pub fn claimants(&self, cell: usize) -> impl Iterator<Item = u32> {
        let cell = cell as u32;
        let first = self.shared.partition_point(|&(c, _)| c < cell);
        self.shared[first..].iter().take_while(move |&&(c, _)| c == cell).map(|&(_, handle)| handle)
    }

    fn set(&mut self, cell: usize, owner: Owner) {
        let was = self.of[cell];
        self.of[cell] = owner;
        let bit = 1 << (cell % 8);
        if owner == FLUID {
            self.fluid[cell / 8] |= bit;
        } else {
            self.fluid[cell / 8] &= !bit;
        }
        self.fluid_cells += usize::from(owner == FLUID);
        self.fluid_cells -= usize::from(was == FLUID);
        self.isolated += usize::from(owner == ISOLATED);
        self.isolated -= usize::from(was == ISOLATED);
    }

    /// Begins a step: nothing was covered or uncovered.
    pub fn begin(&mut self) {
        self.vacated.clear();
        self.covered.clear();
        self.enclosed.clear();
    }

    /// A body leaves a cell.
    pub fn release(&mut self, cell: u32, handle: u32) {
        if self.of[cell as usize] != SHARED {
            self.set(cell as usize, VACATED);
            self.vacated.push(Vacated { cell, handle });
            return;
        }
        if let Ok(place) = self.shared.binary_search(&(cell, handle)) {
            self.shared.remove(place);
        }
        let rest = {
            let mut rest = self.claimants(cell as usize);
            (rest.next(), rest.next())
        };
        if let (Some(last), None) = rest {
            self.shared.retain(|&(c, _)| c != cell);
            self.set(cell as usize, BODY + last);
        }
    }

    /// A body enters a cell.
    pub fn claim(&mut self, cell: u32, handle: u32) {
        let owner = self.of[cell as usize];
        if owner < SHARED {
            if owner == FLUID {
                self.covered.push(cell);
            }
            self.set(cell as usize, BODY + handle);
            return;
        }
        if owner != SHARED {
            self.share(cell, owner - BODY);
            self.set(cell as usize, SHARED);
        }
        self.share(cell, handle);
    }

    fn share(&mut self, cell: u32, handle: u32) {
        if let Err(place) = self.shared.binary_search(&(cell, handle)) {
            self.shared.insert(place, (cell, handle));
        }
    }

    /// Whether any neighbour is fluid or will be.
    fn is_open(&self, grid: &Grid, cell: u32) -> bool {
        let cell = grid.cell_of(cell as usize);
        (1..Q).any(|i| matches!(self.of(grid.neighbour(cell, i)), FLUID | VACATED))
    }

    /// After all releases and claims: decides which cells are isolated. Afterwards `vacated`,
    /// `covered` and `enclosed` are complete; vacated cells become fluid with [`Owners::admit`].
    pub fn settle(&mut self, grid: &Grid) {
        let mut vacated = std::mem::take(&mut self.vacated);
        vacated.retain(|v| {
            let free = self.of(v.cell as usize) == VACATED;
            if free && !self.is_open(grid, v.cell) {
                self.set(v.cell as usize, ISOLATED);
            }
            self.of(v.cell as usize) == VACATED
        });
        // The list grows while it is read: a freed cell frees its isolated neighbours.
        let mut next = 0;
        while next < vacated.len() {
            let Vacated { cell, handle } = vacated[next];
            let cell = grid.cell_of(cell as usize);
            for i in 1..Q {
                let neighbour = grid.neighbour(cell, i);
                if self.of(neighbour) == ISOLATED {
                    self.set(neighbour, VACATED);
                    vacated.push(Vacated { cell: neighbour as u32, handle });
                }
            }
            next += 1;
        }
        self.vacated = vacated;
        for k in 0..self.covered.len() {
            let cell = grid.cell_of(self.covered[k] as usize);
            for i in 1..Q {
                let neighbour = grid.neighbour(cell, i);
                if self.of(neighbour) == FLUID && !self.is_open(grid, neighbour as u32) {
                    self.set(neighbour, ISOLATED);
                    self.enclosed.push(neighbour as u32);
                }
            }
        }
    }

    /// The vacated cells are fluid from now on.
    pub fn admit(&mut self) {
        for k in 0..self.vacated.len() {
            self.set(self.vacated[k].cell as usize, FLUID);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn setup() -> (Grid, Owners, impl Fn([i32; 3]) -> u32) {
        let grid = Grid::new([6, 6, 6], [true; 3]);
        let owners = Owners::new(&grid);
        let place = {
            let grid = grid.clone();
            move |at| grid.index(at) as u32
        };
        (grid, owners, place)
    }

    #[test]
    fn a_cell_handed_from_body_to_body_never_becomes_fluid() {
        let (grid, mut owners, place) = setup();
        let cell = place([2, 2, 2]);
        owners.claim(cell, 7);
        owners.settle(&grid);
        assert_eq!(owners.covered, [cell]);
        owners.begin();
        owners.release(cell, 7);
        owners.claim(cell, 3);
        owners.settle(&grid);
        assert!(owners.covered.is_empty() && owners.vacated.is_empty());
        assert_eq!(owners.of(cell as usize), BODY + 3);
    }

    #[test]
    fn a_shared_cell_stays_solid_until_the_last_body_leaves() {
        let (grid, mut owners, place) = setup();
        let cell = place([1, 2, 3]);
        for handle in [4, 2, 9] {
            owners.claim(cell, handle);
        }
        assert_eq!(owners.claimants(cell as usize).collect::<Vec<_>>(), [2, 4, 9]);
        owners.release(cell, 2);
        assert_eq!(owners.of(cell as usize), SHARED);
        owners.release(cell, 9);
        assert_eq!(owners.of(cell as usize), BODY + 4);
        owners.begin();
        owners.release(cell, 4);
        owners.settle(&grid);
        assert_eq!(owners.vacated, [Vacated { cell, handle: 4 }]);
        owners.admit();
        assert_eq!(owners.fluid_cells, 216);
    }

    #[test]
    fn a_cell_without_fluid_neighbours_is_frozen_and_freed_again() {
        let (grid, mut owners, place) = setup();
        let middle = grid.cell([3, 3, 3]);
        let around: Vec<u32> = (1..Q).map(|i| grid.neighbour(middle, i) as u32).collect();
        for &cell in &around {
            owners.claim(cell, 0);
        }
        owners.settle(&grid);
        assert_eq!(owners.of(middle.index), ISOLATED);
        assert_eq!(owners.enclosed, [middle.index as u32]);
        assert_eq!(owners.isolated, 1);
        owners.begin();
        owners.release(place([2, 3, 3]), 0);
        owners.settle(&grid);
        owners.admit();
        assert_eq!(owners.of(middle.index), FLUID);
        assert_eq!((owners.isolated, owners.fluid_cells), (0, 216 - 17));
    }
}
