//! Lattice-Boltzmann fluid of Tremie: D3Q19 in place, moving spheres, walls, periodic faces.
//!
//! [`Parameters::resolve`] checks the user's choices against a scene; [`FluidLbm`] runs it. The
//! library knows no transport: give it the bodies' states, take the loads.
//!
//! # A step
//! With the bodies at the end of the step: cells that bodies cover leave the fluid and cells that
//! they uncover join it (`owners`, `refill`); all fluid cells collide and stream in one array
//! (`kernel`); populations that ran into walls (`walls`) or bodies (`links`) are reflected;
//! the momentum that they exchanged is the load on the bodies.
//!
//! # Same bits
//! Results depend neither on the number of threads nor on the vector instructions of the processor.

mod balance;
mod bodies;
mod collision;
#[cfg(feature = "component")]
pub mod component;
mod error;
mod field;
mod findings;
mod fluid;
mod grid;
mod kernel;
mod lanes;
pub mod lattice;
mod ledger;
mod links;
mod observe;
mod owners;
mod parameters;
mod refill;
mod resolution;
mod scene_check;
mod solver;
mod sphere;
mod team;
mod units;
mod walls;

pub use error::FluidError;
pub use findings::findings;
pub use fluid::FluidLbm;
pub use lanes::Variant;
pub use ledger::Ledger;
pub use observe::{Diagnostics, SliceNode};
pub use parameters::{Collision, Parameters, Precision};
pub use resolution::Resolution;
