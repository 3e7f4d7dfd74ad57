//! The solver: a step, its settings, loads.

pub mod dragged_body;
pub mod extrapolation;
pub mod free_surface;
pub mod gap_damping;
pub mod held_faces;
pub mod kept_state;
pub mod loads;
pub mod open_faces;
pub mod pic_settings;
pub mod pic_solver;
pub mod pressure_equations;
pub mod pressure_gradient;
pub mod separation;
pub mod shear_equations;
pub mod slip_faces;
pub mod viscosity;
pub mod volume_correction;
pub mod wall_links;
