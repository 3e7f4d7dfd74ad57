//! Linked cells whose bodies come and go one by one.

pub mod body_cells;
pub mod end_rows;
