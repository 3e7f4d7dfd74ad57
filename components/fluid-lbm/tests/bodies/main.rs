//! Tests of the room `bodies`.

#[path = "../common/mod.rs"]
mod common;

mod come_and_go;
mod comoving_sphere;
mod moving_parts;
mod part_buoyancy;
mod part_step;
mod parts;
mod polyhedra;
mod sphere_array;
mod spinning_sphere;
mod surfaces;
mod unions;
