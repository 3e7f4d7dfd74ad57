//! Tests of the room `lattice`.

#[path = "../common/mod.rs"]
mod common;

mod channel;
mod in_place;
mod precision;
mod same_bits;
mod sound;
mod taylor_green;
mod vortices;
