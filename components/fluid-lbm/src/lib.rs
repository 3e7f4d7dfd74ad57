//! Lattice-Boltzmann fluid of Tremie: D3Q19 in place on a list of cells, moving spheres, walls,
//! mirrors, open and periodic faces.
//!
//! [`Parameters::resolve`] checks the user's choices against a scene; [`LbmFluid`] runs it. The
//! library knows no transport: give it the bodies' states, take the loads.
//!
//! # A step
//! With the bodies at the end of the step: cells that bodies cover leave the fluid and cells that
//! they uncover join it (`cell_flags`, `refill`); all fluid cells collide and stream in one array
//! (`collision_kernel`), where the places of populations already see to walls, mirrors and periodic faces
//! (`aa_pattern`); populations that ran into bodies (`post_collision`), curved or moving walls (`static_wall_links`) are
//! reflected; cells at open faces get what these prescribe (`open_boundary`,
//! `nonequilibrium_extrapolation`, `face`, `cylinder`). The momentum exchanged is the
//! load on the bodies, with the pressure in gaps that hold no cell (`unresolved_gaps`). Gaps that the scene
//! declares are frozen while they are thin (`modelled`), and may slip (`specular_walls`). What bodies took from the
//! mass beyond their volume can be paid back (`mass_correction`). Deformable surfaces are bodies whose vertices move
//! by themselves; their facets get the loads (`deformable_shape`, `deformable_surfaces`, `facet_loads`).
//!
//! # Same bits
//! Results depend neither on the number of threads nor on the vector instructions of the processor.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod bodies;
mod boundary;
mod domain;
mod fluid;
mod gaps;
mod lattice;
mod report;
mod solver;

#[cfg(feature = "component")]
pub use fluid::component;

pub use boundary::virtual_piston::face::{ReservoirState, reservoir_signals};
pub use domain::parameters::{
    Collision, GapPressure, OpenFaces, Parameters, Precision, Refill, Walls,
};
pub use fluid::lbm_fluid::LbmFluid;
pub use lattice::d3q19;
pub use lattice::error::FluidError;
pub use lattice::ledger::Ledger;
pub use report::findings::{findings, limits};
pub use report::gap_width_check::Narrow;
pub use report::part_extent::PartExtent;
pub use report::resolution::{Mended, Resolution};
pub use solver::diagnostics::{Diagnostics, SliceNode};
pub use solver::probes::{probe_meanings, probe_signals};
pub use tremie_team::Variant;
