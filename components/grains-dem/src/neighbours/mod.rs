//! Linked cells and the neighbour list (Verlet list) of spheres.

pub mod active_contacts;
pub mod cell_pairs;
pub mod displacement;
pub mod linked_cells;
pub mod neighbour_list;
pub mod neighbour_list_build;
pub mod size_classes;
