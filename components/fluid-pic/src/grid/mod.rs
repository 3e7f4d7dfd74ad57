//! The staggered grid: cells, their rows, and how arrays of them lie in memory.

pub mod cell_rows;
pub mod near_rows;
pub mod periodic_ghosts;
pub mod row_sums;
pub mod staggered_grid;
