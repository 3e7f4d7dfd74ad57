//! The step: neighbour search, forces, velocity Verlet, inlets, probes.

pub mod clumps;
pub mod dem_solver;
pub mod diagnostics;
pub mod exchange;
pub mod force_sum;
pub mod heun;
pub mod integrate;
pub mod interaction_context;
pub mod kept_state;
pub mod moved_bodies;
pub mod neighbour_search;
pub mod overlaps;
pub mod paper_subcycles;
pub mod placement;
pub mod ports;
pub mod probes;
pub mod profiles;
pub mod substeps;
