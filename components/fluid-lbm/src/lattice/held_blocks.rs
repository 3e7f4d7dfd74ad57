//! The blocks of a lattice that one of several ranks stores.

use crate::lattice::layout::{CELLS_PER_BLOCK, block_of};
use std::ops::Range;

/// The cells that one rank holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeldBlocks {
    /// Its blocks, by number in the whole lattice, ascending.
    blocks: Vec<u32>,
    /// Those among them whose cells it counts.
    own: Range<u32>,
    /// Cells of the whole lattice.
    cells_of_whole: usize,
}

impl HeldBlocks {
    /// These blocks, of which it counts some, of a lattice of so many cells.
    pub fn new(blocks: Vec<u32>, own: Range<u32>, cells_of_whole: usize) -> Self {
        Self { blocks, own, cells_of_whole }
    }

    /// Its blocks, by number in the whole lattice, ascending.
    pub fn into_blocks(self) -> impl Iterator<Item = u32> {
        self.blocks.into_iter()
    }

    /// True if a cell is held, by its number in the whole lattice.
    pub fn holds(&self, cell: u32) -> bool {
        self.blocks.binary_search(&block_of(cell)).is_ok()
    }

    /// The cells that it counts, by their numbers among the `held`.
    pub fn own_cells(&self, held: usize) -> Range<u32> {
        let first = self.place(self.own.start).unwrap_or_default();
        let end = first + self.own.end - self.own.start;
        first * CELLS_PER_BLOCK..(end * CELLS_PER_BLOCK).min(held as u32)
    }

    /// Number in the whole lattice of a cell that is held.
    pub fn in_whole(&self, cell: u32) -> u32 {
        self.blocks[block_of(cell) as usize] * CELLS_PER_BLOCK + cell % CELLS_PER_BLOCK
    }

    /// Number here of a cell of the whole lattice, if it is held.
    pub fn here(&self, cell: u32) -> Option<u32> {
        let place = self.place(block_of(cell))?;
        Some(place * CELLS_PER_BLOCK + cell % CELLS_PER_BLOCK)
    }

    /// Its blocks, as runs of such that follow each other.
    pub fn runs(&self) -> impl Iterator<Item = Range<u32>> {
        self.blocks.chunk_by(|a, b| a + 1 == *b).map(|run| run[0]..run[run.len() - 1] + 1)
    }

    /// Those among them whose cells it counts.
    pub fn own(&self) -> Range<u32> {
        self.own.clone()
    }

    /// Cells of the whole lattice.
    pub fn cells_of_whole(&self) -> usize {
        self.cells_of_whole
    }

    /// Place of a block of the whole lattice among those that are held.
    pub fn place(&self, block: u32) -> Option<u32> {
        self.blocks.binary_search(&block).ok().map(|place| place as u32)
    }
}
