//! The step: bodies, collision, reflection, loads, balance; and the fluid in SI units.

pub mod budget;
pub mod collide_and_stream;
pub mod crossing_bodies;
pub mod deformable_surfaces;
pub mod diagnostics;
pub mod execution;
pub mod facet_loads;
pub mod far_means;
pub mod gap_flows;
pub mod gap_model;
pub mod gap_pressure;
mod kept_state;
pub mod lattice_state;
pub mod lbm_solver;
pub mod loads;
pub mod lost_mass;
pub mod mass_correction;
pub mod moving_bodies;
pub mod moving_boundaries;
pub mod open_boundaries;
pub mod oriented_messages;
pub mod pinched_cells;
pub mod ports;
pub mod probes;
pub mod section_flux;
pub mod static_boundaries;
