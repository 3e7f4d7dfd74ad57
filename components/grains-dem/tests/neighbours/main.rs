//! Tests of the room `neighbours`.

#[path = "../common/mod.rs"]
mod common;

mod mixed_sizes;
mod periodic;
mod small_periodic_boxes;
