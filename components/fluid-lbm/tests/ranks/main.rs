//! Tests of the room `ranks`: a lattice in shares has the same bits as one in one piece.

#[path = "../common/mod.rs"]
mod common;

mod gaps;
mod kept;
mod same_bits;
mod story;
mod thread_ranks;
