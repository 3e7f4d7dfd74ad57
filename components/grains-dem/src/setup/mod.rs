//! Before a run: checks, time step, memory.

pub mod check;
pub mod check_clumps;
pub mod check_drag_bands;
pub mod check_integrator;
pub mod check_law;
pub mod check_polyhedra;
pub mod check_ports;
pub mod check_profiles;
pub mod check_slider;
pub mod check_surface;
pub mod material_pairs;
pub mod memory_need;
pub mod resolution;
pub mod slider_times;
pub mod softness;
pub mod step_limit;
