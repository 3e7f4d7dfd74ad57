//! A scene in cells: what is solid, what moves, ways of the fluid, displaced volume.

pub mod displaced_volume;
pub mod leak;
pub mod mirrors;
pub mod solids;
pub mod static_geometry;
pub mod voxels;
