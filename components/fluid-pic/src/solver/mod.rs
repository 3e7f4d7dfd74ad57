//! The solver: a step, its settings, loads.

pub mod extrapolation;
pub mod free_surface;
pub mod loads;
pub mod pic_settings;
pub mod pic_solver;
pub mod separation;
pub mod viscosity;
pub mod volume_correction;
