//! The map of stored cells: which are fluid, which belong to bodies.
//!
//! Bodies move by releasing cells and claiming others, all releases before all claims, one thread,
//! in the order of the bodies. [`CellFlags::settle`] then says which cells joined the fluid, which
//! left it, and which fluid cells have no fluid neighbour left; those are frozen as solid until a
//! neighbour becomes fluid again.

use crate::lattice::d3q19::Q;
use crate::lattice::layout::Layout;
use crate::lattice::whole_numbers::WholeNumbers;
use std::ops::Range;
use tremie_state::{StateError, StateExchange};

/// Owner of a cell.
pub type Owner = u32;

/// Nobody: the cell is fluid.
pub const FLUID: Owner = 0;
/// A cell of a gap that is too thin to hold fluid, or of a pocket; see `modelled`.
pub const FROZEN: Owner = 1;
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
pub struct CellFlags {
    of: Vec<Owner>,
    /// One bit a cell: whether it is fluid.
    fluid: Vec<u8>,
    /// One bit a cell: whether more than one body holds it.
    held_twice: Vec<u8>,
    /// Claims on shared cells, sorted: (cell, handle).
    shared: Vec<(u32, u32)>,
    /// Cells that joined the fluid in this step.
    pub vacated: Vec<Vacated>,
    /// Cells that bodies took from the fluid in this step.
    pub covered: Vec<u32>,
    /// Fluid cells that were left without fluid neighbours in this step.
    pub enclosed: Vec<u32>,
    /// Cells without fluid neighbours, at the end of the last step; of those that are counted.
    pub isolated: usize,
    /// Frozen cells of gaps and pockets; of those that are counted.
    pub frozen: usize,
    /// Fluid cells among those that are counted.
    pub fluid_cells: usize,
    /// Fluid cells among all that are stored.
    stored_fluid: usize,
    /// The cells that are counted, see `Layout::own`.
    own: Range<u32>,
    changes: Option<Changes>,
}

/// Cells whose owner changed, each once.
#[derive(Clone, Debug)]
struct Changes {
    cells: Vec<u32>,
    is_listed: Vec<bool>,
}

impl CellFlags {
    /// All of `cells` cells fluid, of which some are counted.
    pub fn new(cells: usize, own: Range<u32>) -> Self {
        let mut fluid = vec![0xff; cells / 8];
        fluid.push((1_u32 << (cells % 8)) as u8 - 1);
        // Words are read whole.
        fluid.extend([0; 9]);
        Self {
            of: vec![FLUID; cells],
            fluid,
            held_twice: vec![0; cells / 8 + 1],
            shared: Vec::new(),
            vacated: Vec::new(),
            covered: Vec::new(),
            enclosed: Vec::new(),
            isolated: 0,
            frozen: 0,
            fluid_cells: own.len(),
            stored_fluid: cells,
            own,
            changes: None,
        }
    }

    /// Keeps whose the cells are, or puts it back; `is_alive` says of a handle whether its body
    /// lives.
    ///
    /// # Errors
    /// A state of other cells or bodies.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        numbers: &WholeNumbers,
        is_alive: impl Fn(u32) -> bool,
    ) -> Result<(), StateError> {
        let claims = self.shared.iter().filter(|(cell, _)| numbers.is_own(*cell));
        let mut shared: Vec<_> =
            claims.map(|&(cell, handle)| [numbers.in_whole(cell), handle]).collect();
        let left = self.vacated.iter().filter(|vacated| numbers.is_own(vacated.cell));
        let mut vacated: Vec<_> = left.map(|v| [numbers.in_whole(v.cell), v.handle]).collect();
        let mut covered = numbers.kept(&self.covered);
        numbers.exchange_values(state, "owners", &mut self.of)?;
        state.shared_list("shared", &mut shared)?;
        state.shared_list("covered", &mut covered)?;
        state.shared_list("vacated", &mut vacated)?;
        if state.restores() {
            let here = |[cell, handle]: [u32; 2]| Some((numbers.here(cell)?, handle));
            self.shared = shared.into_iter().filter_map(here).collect();
            self.covered = numbers.stored(&covered);
            let vacated = vacated.into_iter().filter_map(here);
            self.vacated = vacated.map(|(cell, handle)| Vacated { cell, handle }).collect();
            if !self.are_held_by(is_alive) {
                return state.unfit("the cells of the state are not held by its bodies");
            }
            self.survey();
        }
        Ok(())
    }

    /// True if whoever holds a cell lives, and the claims on shared cells are in order.
    fn are_held_by(&self, is_alive: impl Fn(u32) -> bool) -> bool {
        let is_owner = |&owner: &Owner| match owner {
            FLUID | FROZEN | ISOLATED | SHARED => true,
            owner => owner.checked_sub(BODY).is_some_and(&is_alive),
        };
        let is_claim = |&(cell, handle): &(u32, u32)| {
            self.of.get(cell as usize) == Some(&SHARED) && is_alive(handle)
        };
        self.of.iter().all(is_owner)
            && self.shared.iter().all(is_claim)
            && self.shared.is_sorted_by(|a, b| a < b)
    }

    /// Finds bits and numbers of cells from whose they are.
    fn survey(&mut self) {
        self.fluid.fill(0);
        self.held_twice.fill(0);
        (self.fluid_cells, self.isolated, self.frozen) = (0, 0, 0);
        self.stored_fluid = 0;
        for (cell, &owner) in self.of.iter().enumerate() {
            let (bit, counts) = (1 << (cell % 8), self.own.contains(&(cell as u32)));
            match owner {
                FLUID => {
                    self.fluid[cell / 8] |= bit;
                    self.stored_fluid += 1;
                    self.fluid_cells += usize::from(counts);
                }
                SHARED => self.held_twice[cell / 8] |= bit,
                ISOLATED => self.isolated += usize::from(counts),
                FROZEN => self.frozen += usize::from(counts),
                _ => {}
            }
        }
    }

    /// Lists from now on which cells change hands.
    pub fn list_changes(&mut self) {
        let cells = self.of.len();
        let (cells, is_listed) = (Vec::with_capacity(cells), vec![false; cells]);
        self.changes = Some(Changes { cells, is_listed });
    }

    /// Cells that changed hands since the list was last emptied, if there is one.
    pub fn changed(&self) -> &[u32] {
        self.changes.as_ref().map_or(&[], |changes| &changes.cells)
    }

    /// Empties the list of changes.
    pub fn forget_changes(&mut self) {
        if let Some(Changes { cells, is_listed }) = &mut self.changes {
            for cell in cells.drain(..) {
                is_listed[cell as usize] = false;
            }
        }
    }

    fn note(&mut self, cell: u32) {
        if let Some(Changes { cells, is_listed }) = &mut self.changes
            && !std::mem::replace(&mut is_listed[cell as usize], true)
        {
            cells.push(cell);
        }
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
    pub fn of(&self, cell: u32) -> Owner {
        self.of[cell as usize]
    }

    /// True if a cell is fluid.
    #[inline(always)]
    pub fn is_fluid(&self, cell: u32) -> bool {
        self.fluid[cell as usize / 8] >> (cell % 8) & 1 == 1
    }

    /// Fluid cells among those with consecutive numbers from `number` on, one for each bit set in
    /// `cells`.
    #[inline(always)]
    pub fn fluid_among(&self, cells: u64, mut number: u32) -> u64 {
        let (mut rest, mut fluid) = (cells, 0);
        // Mostly one run of bits.
        while rest != 0 {
            let begin = rest.trailing_zeros();
            let run = (rest >> begin).trailing_ones();
            let mask = u64::MAX >> (64 - run) << begin;
            fluid |= self.fluid_from(number) << begin & mask;
            rest &= !mask;
            number += run;
        }
        fluid
    }

    /// Fluid cells among the 64 from `number` on, a bit each.
    #[inline(always)]
    fn fluid_from(&self, number: u32) -> u64 {
        let (first, shift) = (number as usize / 8, number % 8);
        let bytes = &self.fluid[first..first + 9];
        let word = u64::from_le_bytes(std::array::from_fn(|k| bytes[k]));
        // In two steps, because none by 64 is a shift.
        word >> shift | u64::from(bytes[8]) << 1 << (63 - shift)
    }

    /// True if more than one body holds a cell.
    #[inline(always)]
    pub fn is_shared(&self, cell: u32) -> bool {
        self.held_twice[cell as usize / 8] >> (cell % 8) & 1 == 1
    }

    /// True if every cell is fluid.
    #[inline(always)]
    pub fn all_fluid(&self) -> bool {
        self.stored_fluid == self.of.len()
    }

    /// Memory that the map takes [bytes].
    pub fn bytes(&self) -> usize {
        let changes = self.changes.as_ref().map_or(0, |changes| 5 * changes.is_listed.len());
        4 * self.of.len() + 2 * self.fluid.len() + changes
    }

    /// Handles of the bodies that hold cells with others, some more than once.
    pub fn sharing(&self) -> impl Iterator<Item = u32> {
        self.shared.iter().map(|&(_, handle)| handle)
    }

    /// One bit a cell: whether it is fluid.
    pub fn fluid_bits(&self) -> &[u8] {
        &self.fluid
    }

    /// Handles of the bodies that claim a shared cell.
    pub fn claimants(&self, cell: u32) -> impl Iterator<Item = u32> {
        let first = self.shared.partition_point(|&(c, _)| c < cell);
        self.shared[first..].iter().take_while(move |&&(c, _)| c == cell).map(|&(_, handle)| handle)
    }

    /// Handle of the body that holds a cell, of several the first.
    pub fn holder(&self, cell: u32) -> Option<u32> {
        match self.of(cell) {
            SHARED => self.claimants(cell).next(),
            owner => owner.checked_sub(BODY),
        }
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
        if (owner == SHARED) != (was == SHARED) {
            self.held_twice[cell / 8] ^= bit;
        }
        self.stored_fluid += usize::from(owner == FLUID);
        self.stored_fluid -= usize::from(was == FLUID);
        if self.own.contains(&(cell as u32)) {
            self.fluid_cells += usize::from(owner == FLUID);
            self.fluid_cells -= usize::from(was == FLUID);
            self.isolated += usize::from(owner == ISOLATED);
            self.isolated -= usize::from(was == ISOLATED);
            self.frozen += usize::from(owner == FROZEN);
            self.frozen -= usize::from(was == FROZEN);
        }
        self.note(cell as u32);
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
            self.note(cell);
        }
        let rest = {
            let mut rest = self.claimants(cell);
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

    /// A cell of a gap freezes.
    pub fn freeze(&mut self, cell: u32) {
        if self.of(cell) == FLUID {
            self.enclosed.push(cell);
        }
        self.set(cell as usize, FROZEN);
    }

    /// A frozen cell thaws.
    pub fn thaw(&mut self, vacated: Vacated) {
        self.set(vacated.cell as usize, VACATED);
        self.vacated.push(vacated);
    }

    /// Takes over from the rank that counts a cell whether that is cut off from the fluid.
    #[inline]
    pub fn correct(&mut self, cell: u32, is_isolated: bool) {
        let owner = if is_isolated { ISOLATED } else { FLUID };
        let was = self.of(cell);
        if was != owner && matches!(was, FLUID | ISOLATED) {
            self.set(cell as usize, owner);
        }
    }

    /// Forgets released cells that froze.
    pub fn forget_frozen_vacated(&mut self) {
        let mut vacated = std::mem::take(&mut self.vacated);
        vacated.retain(|v| self.of(v.cell) == VACATED);
        self.vacated = vacated;
    }

    fn share(&mut self, cell: u32, handle: u32) {
        if let Err(place) = self.shared.binary_search(&(cell, handle)) {
            self.shared.insert(place, (cell, handle));
            self.note(cell);
        }
    }

    /// True if any neighbour is fluid or will be.
    fn is_open(&self, layout: &Layout, cell: u32) -> bool {
        let mut neighbours = (1..Q).filter_map(|i| layout.neighbour(cell, i));
        // A cell at a mirror has itself for a neighbour.
        neighbours.any(|n| n != cell && matches!(self.of(n), FLUID | VACATED))
            || (1..Q).any(|i| layout.sees_itself(cell, i))
    }

    /// After all releases and claims: decides which cells are isolated. Afterwards `vacated`,
    /// `covered` and `enclosed` are complete; vacated cells become fluid with [`CellFlags::admit`].
    pub fn settle(&mut self, layout: &Layout) {
        let mut vacated = std::mem::take(&mut self.vacated);
        vacated.retain(|v| {
            let free = self.of(v.cell) == VACATED;
            if free && !self.is_open(layout, v.cell) {
                self.set(v.cell as usize, ISOLATED);
            }
            self.of(v.cell) == VACATED
        });
        // The list grows while it is read: a freed cell frees its isolated neighbours.
        let mut next = 0;
        while next < vacated.len() {
            let Vacated { cell, handle } = vacated[next];
            for i in 1..Q {
                if let Some(neighbour) = layout.neighbour(cell, i)
                    && self.of(neighbour) == ISOLATED
                {
                    self.set(neighbour as usize, VACATED);
                    vacated.push(Vacated { cell: neighbour, handle });
                }
            }
            next += 1;
        }
        self.vacated = vacated;
        for k in 0..self.covered.len() {
            for i in 1..Q {
                if let Some(neighbour) = layout.neighbour(self.covered[k], i)
                    && self.of(neighbour) == FLUID
                    && !self.is_open(layout, neighbour)
                {
                    self.set(neighbour as usize, ISOLATED);
                    self.enclosed.push(neighbour);
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
    use tremie_fluid_kit::cells::grid::Grid;

    fn setup() -> (Layout, CellFlags, impl Fn([i32; 3]) -> u32) {
        let layout = Layout::open(Grid::walled([6, 6, 6], [true; 3]));
        let flags = CellFlags::new(layout.cells.len(), layout.own.clone());
        let place = {
            let layout = layout.clone();
            move |at| layout.cell(at).unwrap()
        };
        (layout, flags, place)
    }

    #[test]
    fn a_cell_handed_from_body_to_body_never_becomes_fluid() {
        let (layout, mut flags, place) = setup();
        let cell = place([2, 2, 2]);
        flags.claim(cell, 7);
        flags.settle(&layout);
        assert_eq!(flags.covered, [cell]);
        flags.begin();
        flags.release(cell, 7);
        flags.claim(cell, 3);
        flags.settle(&layout);
        assert!(flags.covered.is_empty() && flags.vacated.is_empty());
        assert_eq!(flags.of(cell), BODY + 3);
    }

    #[test]
    fn a_shared_cell_stays_solid_until_the_last_body_leaves() {
        let (layout, mut flags, place) = setup();
        let cell = place([1, 2, 3]);
        for handle in [4, 2, 9] {
            flags.claim(cell, handle);
        }
        assert_eq!(flags.claimants(cell).collect::<Vec<_>>(), [2, 4, 9]);
        flags.release(cell, 2);
        assert_eq!(flags.of(cell), SHARED);
        flags.release(cell, 9);
        assert_eq!(flags.of(cell), BODY + 4);
        flags.begin();
        flags.release(cell, 4);
        flags.settle(&layout);
        assert_eq!(flags.vacated, [Vacated { cell, handle: 4 }]);
        flags.admit();
        assert_eq!(flags.fluid_cells, 216);
    }

    #[test]
    fn a_cell_without_fluid_neighbours_is_frozen_and_freed_again() {
        let (layout, mut flags, place) = setup();
        let middle = place([3, 3, 3]);
        let around: Vec<u32> = (1..Q).map(|i| layout.neighbour(middle, i).unwrap()).collect();
        for &cell in &around {
            flags.claim(cell, 0);
        }
        flags.settle(&layout);
        assert_eq!(flags.of(middle), ISOLATED);
        assert_eq!(flags.enclosed, [middle]);
        assert_eq!(flags.isolated, 1);
        flags.begin();
        flags.release(place([2, 3, 3]), 0);
        flags.settle(&layout);
        flags.admit();
        assert_eq!(flags.of(middle), FLUID);
        assert_eq!((flags.isolated, flags.fluid_cells), (0, 216 - 17));
    }
}
