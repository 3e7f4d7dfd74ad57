//! Particle-in-cell fluid of Tremie: free surfaces, cut cells, implicit bodies.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod grid;
pub mod particles;
pub mod pressure;
pub mod solids;
pub mod solver;
pub mod surface;
