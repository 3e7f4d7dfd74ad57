//! Static geometry in cells: solids, faces of the domain, parameters.

pub mod boundary_condition;
pub mod lattice_orientation;
pub mod link_meeting;
pub mod parameters;
