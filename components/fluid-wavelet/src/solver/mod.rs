//! Steps of the gas on its adaptive grid.

pub mod domain_faces;
pub mod sponge;
pub mod wavelet_solver;
