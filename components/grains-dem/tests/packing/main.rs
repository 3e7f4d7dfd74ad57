//! Tests of the room `packing`.

#[path = "../common/mod.rs"]
mod common;

mod packing;
