//! Tests of the room `report`.

#[path = "../common/mod.rs"]
mod common;

mod parameters;
