//! A step of the fluid.

pub mod extrapolation;
pub mod free_surface;
pub mod pic_solver;
