//! Tests of the room `ranks`: a lattice in shares has the same bits as one in one piece.

#[path = "../common/mod.rs"]
mod common;

mod same_bits;
mod thread_ranks;
