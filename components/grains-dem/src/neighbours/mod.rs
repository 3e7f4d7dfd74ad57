//! Linked cells and the neighbour list (Verlet list) of spheres.

pub mod active_contacts;
pub mod displacement;
pub mod neighbour_list;
pub mod neighbour_list_build;
