//! Tests of the room `polyhedra`.

#[path = "../common/mod.rs"]
mod common;

mod polyhedra;
mod polyhedra_one_wall;
mod polyhedra_oracle;
mod polyhedra_rest;
mod prisms;
