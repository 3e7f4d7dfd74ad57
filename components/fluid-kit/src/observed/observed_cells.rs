//! A fluid whose cells can be seen.

use tremie_messages::frame::SliceNode;

/// A fluid in a box of cells that observers may look at.
pub trait ObservedCells {
    /// Cells along each axis.
    fn cells(&self) -> [usize; 3];
    /// Centre of a cell [m].
    fn centre(&self, cell: [usize; 3]) -> [f64; 3];
    /// State of a cell.
    fn node(&self, cell: [usize; 3]) -> SliceNode;
}
