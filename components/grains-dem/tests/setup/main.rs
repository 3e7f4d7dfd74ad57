//! Tests of the room `setup`.

#[path = "../common/mod.rs"]
mod common;

mod problems;
mod softness;
