//! Numbers of cells in the whole lattice: by these a state is kept, so that any number of ranks can put it back.

use crate::lattice::held_blocks::HeldBlocks;
use crate::lattice::layout::{CELLS_PER_BLOCK, Layout};
use std::ops::Range;
use tremie_state::{SharedRows, StateError, StateExchange, StateNumber};

/// Which cells of the whole lattice those are that a rank stores.
#[derive(Clone, Debug, Default)]
pub struct WholeNumbers {
    /// Its blocks, if it does not store all.
    window: Option<HeldBlocks>,
    /// Cells of the whole lattice.
    all: usize,
    /// Those that it counts, by their numbers here.
    own: Range<u32>,
}

impl WholeNumbers {
    /// Of the cells that were laid out for a window.
    pub fn new(layout: &Layout, window: Option<HeldBlocks>) -> Self {
        let all = window.as_ref().map_or(layout.cells.len(), HeldBlocks::cells_of_whole);
        Self { window, all, own: layout.own.clone() }
    }

    /// Number in the whole lattice of a cell that is stored.
    pub fn in_whole(&self, cell: u32) -> u32 {
        self.window.as_ref().map_or(cell, |window| window.in_whole(cell))
    }

    /// Number here of a cell of the whole lattice, if it is stored.
    pub fn here(&self, cell: u32) -> Option<u32> {
        match &self.window {
            None => Some(cell).filter(|&cell| (cell as usize) < self.all),
            Some(window) => window.here(cell).filter(|_| (cell as usize) < self.all),
        }
    }

    /// True if this rank counts a cell that is stored.
    pub fn is_own(&self, cell: u32) -> bool {
        self.own.contains(&cell)
    }

    /// The cells in groups of so many that follow each other, as rows of an array.
    pub fn rows_of(&self, group: usize) -> SharedRows {
        let all = self.all.div_ceil(group);
        let Some(window) = &self.window else { return SharedRows::whole(all) };
        let per_block = CELLS_PER_BLOCK as usize / group;
        let rows = |blocks: Range<u32>| {
            blocks.start as usize * per_block..(blocks.end as usize * per_block).min(all)
        };
        SharedRows { all, own: rows(window.own()), held: window.runs().map(rows).collect() }
    }

    /// Keeps a value of each stored cell, of all ranks, or puts them back.
    ///
    /// # Errors
    /// A state of another lattice.
    pub fn exchange_values<T: StateNumber>(
        &self,
        state: &mut StateExchange<'_>,
        name: &str,
        values: &mut [T],
    ) -> Result<(), StateError> {
        let restores = state.restores();
        state.shared_array(name, &self.rows_of(1), |first, rows: &mut [T]| {
            let Some(first) = self.here(first as u32) else { return };
            let own = &mut values[first as usize..][..rows.len()];
            if restores { own.copy_from_slice(rows) } else { rows.copy_from_slice(own) }
        })
    }

    /// The cells among some that this rank keeps, by their numbers in the whole lattice.
    pub fn kept(&self, cells: &[u32]) -> Vec<u32> {
        let own = cells.iter().filter(|&&cell| self.is_own(cell));
        own.map(|&cell| self.in_whole(cell)).collect()
    }

    /// The cells among some of the whole lattice that are stored here.
    pub fn stored(&self, cells: &[u32]) -> Vec<u32> {
        cells.iter().filter_map(|&cell| self.here(cell)).collect()
    }
}
