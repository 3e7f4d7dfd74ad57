//! Tests of the room `walls`.

#[path = "../common/mod.rs"]
mod common;

mod endless;
mod face_forces;
mod one_wall;
mod soft_beside_rigid;
