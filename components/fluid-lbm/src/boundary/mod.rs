//! Boundary schemes: bounce-back by links, open faces, the virtual piston.

pub mod boundaries;
pub mod bouzidi;
pub mod convective_outflow;
pub mod cut_links;
pub mod face_scheme;
pub mod face_schemes;
pub mod gap_sinks;
pub mod link_batch;
pub mod link_kernels;
pub mod mesh_links;
pub mod nonequilibrium_extrapolation;
pub mod open_area;
pub mod open_boundary;
pub mod population_addresses;
pub mod post_collision;
pub mod refill;
pub mod sheet_links;
pub mod sphere_links;
pub mod static_wall_links;
pub mod unresolved_gaps;
pub mod unresolved_part_gaps;
pub mod virtual_piston;
pub mod wall_distances;
pub mod wall_mass;
pub mod zou_he;
