//! The adaptive grid: a tree of blocks of points, and interpolating wavelets between its levels.

pub mod adaptation;
pub mod block_shape;
pub mod block_tree;
pub mod block_values;
pub mod prediction;
pub mod short_copy;
