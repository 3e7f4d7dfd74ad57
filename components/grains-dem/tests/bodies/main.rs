//! Tests of the room `bodies`.

#[path = "../common/mod.rs"]
mod common;

mod motions;
mod parts;
mod sliders;
mod surfaces;
