//! Static geometry in cells: solids, faces of the domain, parameters.

pub mod boundary_condition;
pub mod displaced_volume;
pub mod lattice_orientation;
pub mod leak;
pub mod mirrors;
pub mod parameters;
pub mod sampling;
pub mod solids;
pub mod static_geometry;
pub mod voxels;
