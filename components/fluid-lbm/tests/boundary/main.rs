//! Tests of the room `boundary`.

#[path = "../common/mod.rs"]
mod common;

mod cubes;
mod delivered;
mod endless;
mod mirrors;
mod near_walls;
mod open_faces;
mod oscillating;
mod part_reservoirs;
mod reservoirs;
mod virtual_piston;
