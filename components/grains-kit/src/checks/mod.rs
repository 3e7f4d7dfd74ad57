//! Checks of a scene before a run, with a problem for each fault.

pub mod check_packing;
pub mod check_scene;
pub mod check_sizes;
pub mod loads;
pub mod numbers;
