//! The box of cells.

pub mod centres;
pub mod flattened;
pub mod grid;
pub mod links;
pub mod obstacles;
pub mod vector;
pub mod whole_cells;
