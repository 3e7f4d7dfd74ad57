//! Compressible fluid on a grid that follows it: collocation with interpolating wavelets, in blocks.
//!
//! The physics and their sources: Goetsch, *A numerical approach to the simulation of granular and
//! multiphase flows*, thesis, Iowa State University (2015), ch. 2; Vasilyev, *Int. J. Comput. Fluid
//! Dyn.* 17 (2003) 151.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod bodies;
mod domain;
mod fluid;
pub mod gas;
pub mod grid;
mod report;
pub mod solver;

#[cfg(feature = "component")]
pub use fluid::{benchmark::benchmarks, component};

pub use domain::parameters::{LoadName, Parameters, SpongeTable};
pub use fluid::error::GasError;
pub use fluid::gas_fluid::{GasFluid, GasFluidState};
pub use report::findings::{findings, limits};
pub use report::resolution::Resolution;

pub use bodies::gas_body::{Ball, BodyLoad, GasBody, HalfSpace, SurfaceHeat};
pub use gas::gas_law::{Gas, GasState};
pub use solver::domain_faces::{DomainFace, DomainFaces};
pub use solver::sponge::Sponge;
pub use solver::wavelet_solver::{NoGasError, WaveletSettings, WaveletSolver};
