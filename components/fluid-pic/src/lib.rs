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
//! let mut solver = PicSolver::new(grid, PicSettings::water([0.0, -9.81]), 1, |_, _| false)?;
//! let disc = RigidBody {
//!     centre: [0.5, 0.25],
//!     radius: 0.15,
//!     velocity: [0.0; 2],
//!     mass: Some(7.0),
//!     force: [0.0; 2],
//! };
//! let is_wet = |x: [f64; 2]| x[1] < 0.5 && (x[0] - 0.5).hypot(x[1] - 0.25) > disc.radius;
//! seed(&solver.grid, &mut solver.particles, 2, 0.5, 1, is_wet, |_| [0.0; 2]);
//! let mut forces = Vec::new();
//! let outcome = solver.step(1e-3, &[disc], &mut forces);
//! assert!(outcome.converged);
//! // It rises: the fluid lifts it by more than its weight.
//! assert!(forces[0][1] > 7.0 * 9.81);
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! Surface tension is left out, and so is air. The fluid has no viscosity yet, and walls do not
//! hold it back.
//!
//! # Same bits
//!
//! Equal scenes give equal bits on any number of threads: sums are taken in the order of the cells.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod grid;
mod particles;
mod pressure;
mod solids;
mod solver;
mod surface;

pub use grid::staggered_grid::StaggeredGrid;
pub use particles::particle_arrays::{ParticleArrays, Transfer};
pub use particles::seeding::seed;
pub use pressure::conjugate_gradients::{PressureOutcome, Tolerance};
pub use solids::rigid_body::RigidBody;
pub use solver::free_surface::SurfaceOrder;
pub use solver::pic_solver::{PicSettings, PicSolver};
