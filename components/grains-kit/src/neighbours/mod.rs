//! Linked cells in levels of sizes, and the pairs near each other.

pub mod cell_pairs;
pub mod linked_cells;
pub mod size_classes;
