//! Particle-in-cell fluid of Tremie: an incompressible fluid with a free surface, in two or three
//! dimensions, and rigid bodies in it.
//!
//! ```text
//! div u = 0      du/dt + u . grad u = - grad p / rho + g      p = 0 at the surface
//! ```
//!
//! Particles carry mass and momentum; they are the advection and mark the surface. A staggered grid
//! keeps the volume. Bodies cut its cells, and the pressure is solved for together with their
//! velocities, so that a body may be as light as it likes (Chen, Zhang, Zang & Ning, *J. Fluids
//! Struct.* 91 (2019) 102772). [`PicSolver::step`] has the order of a step.
//!
//! ```
//! use tremie_fluid_pic::{PicSettings, PicSolver, RigidBody, StaggeredGrid, seed};
//!
//! // A box of 1 m, half full, and a light disc under water.
//! let grid = StaggeredGrid::new([20, 20], 0.05, [0.0; 2], [false; 2]);
//! let settings = PicSettings::water([0.0, -9.81]);
//! let mut solver = PicSolver::new(grid, settings, 1, Vec::new(), Vec::new())?;
//! let disc = RigidBody::ball([0.5, 0.25], 0.15).with_mass(7.0);
//! let is_wet = |x: [f64; 2]| x[1] < 0.5 && !disc.holds(x);
//! seed(&solver.grid, &mut solver.particles, 2, 0.5, 1, is_wet, |_| [0.0; 2]);
//! let mut loads = Vec::new();
//! let outcome = solver.step(1e-3, &[disc], &mut loads);
//! assert!(outcome.converged);
//! // It rises: the fluid lifts it by more than its weight.
//! assert!(loads[0][1] > 7.0 * 9.81);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! Surface tension is left out, and so is air.
//!
//! # Same bits
//!
//! Equal scenes give equal bits on any number of threads: sums are taken in the order of the cells.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod domain;
mod fluid;
mod grid;
mod particles;
mod pressure;
mod report;
mod solids;
mod solver;
mod surface;

#[cfg(feature = "component")]
pub use fluid::{benchmark::benchmarks, component};

pub use domain::parameters::{
    ContactForces, GapDampingTable, Parameters, SurfaceName, TransferName, WallName,
};
pub use fluid::error::FluidError;
pub use fluid::pic_fluid::{FluidState, PicFluid};
pub use grid::staggered_grid::StaggeredGrid;
pub use particles::particle_arrays::{ParticleArrays, Transfer};
pub use particles::seeding::seed;
pub use pressure::body_coupling::Wrench;
pub use pressure::conjugate_gradients::{PressureOutcome, Tolerance};
pub use report::findings::{findings, limits};
pub use report::resolution::Resolution;
pub use solids::half_spaces::HalfSpaces;
pub use solids::rigid_body::{BodyShape, Freedom, RigidBody};
pub use solids::section::Section;
pub use solids::surface_solid::SurfaceSolid;
pub use solver::free_surface::SurfaceOrder;
pub use solver::gap_damping::GapDamping;
pub use solver::loads::FluidSums;
pub use solver::open_faces::{FaceFlow, OpenFace};
pub use solver::pic_settings::{BoxWall, PicSettings};
pub use solver::pic_solver::PicSolver;
pub use solver::pressure_equations::PressureEquations;
