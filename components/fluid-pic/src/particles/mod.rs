//! Particles of fluid: they carry mass and momentum, are the advection, and mark the surface.

pub mod cell_order;
pub mod from_grid;
pub mod hat_weights;
mod lane_weights;
pub mod particle_arrays;
pub mod seeding;
pub mod to_grid;
