//! Particle-in-cell fluid of Tremie: free surfaces, cut cells, implicit bodies.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod grid;
pub mod pressure;
