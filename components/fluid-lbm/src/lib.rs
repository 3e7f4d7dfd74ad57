//! Lattice-Boltzmann fluid of Tremie: D3Q19 in place on a list of cells, moving spheres, walls,
//! mirrors, open and periodic faces.
//!
//! [`Parameters::resolve`] checks the user's choices against a scene; [`LbmFluid`] runs it. The
//! library knows no transport: give it the bodies' states, take the loads.
//!
//! # A step
//! With the bodies at the end of the step:
//!
//! 1. Cells that bodies cover leave the fluid, and cells that they uncover join it (`solver/moving_boundaries`, `lattice/cell_flags`,
//!    `boundary/refill`).
//! 2. All fluid cells collide and stream in one array (`lattice/collision_kernel`). The addresses of populations already see to
//!    half-way walls, mirrors and periodic faces (`lattice/aa_pattern`).
//! 3. Populations that ran into bodies (`boundary/link_batch`), and into curved or moving walls (`boundary/static_wall_links`), are
//!    reflected by Bouzidi's interpolation (`boundary/bouzidi`). The momentum exchanged is the load on bodies and parts.
//! 4. Gaps that hold no cell press on bodies (`boundary/unresolved_gaps`). Declared gaps are frozen while they are thin
//!    (`gaps/modelled`), and their walls may slip (`gaps/specular_walls`).
//! 5. Cells at open faces get what these prescribe, each face by its scheme (`boundary/face_schemes`, `boundary/open_boundary`,
//!    `boundary/zou_he`, `boundary/convective_outflow`, `boundary/virtual_piston`).
//! 6. Loads are put together (`solver/loads`, `solver/facet_loads`), and what walls and bodies took from the mass is paid back
//!    (`solver/mass_correction`, `boundary/wall_mass`).
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
mod ranks;
mod report;
mod solver;

#[cfg(feature = "component")]
pub use fluid::{benchmark::benchmarks, component};

pub use boundary::virtual_piston::reservoir_state::ReservoirState;
pub use domain::parameters::{
    Collision, GapPressure, OpenFaces, Parameters, Precision, Refill, Walls,
};
pub use fluid::lbm_fluid::LbmFluid;
pub use lattice::d3q19;
pub use lattice::error::FluidError;
pub use lattice::ledger::Ledger;
pub use lattice::reservoir_place::ReservoirPlace;
pub use ranks::communicator::{Communicator, Parcel};
pub use report::findings::{findings, limits};
pub use report::resolution::Resolution;
pub use solver::diagnostics::{Diagnostics, Extreme, SliceNode};
pub use tremie_fluid_kit::checks::gap_width_check::Narrow;
pub use tremie_fluid_kit::checks::mended_part::MendedPart;
pub use tremie_fluid_kit::checks::part_extent::PartExtent;
pub use tremie_fluid_kit::probes::probe_signals::probe_signals;
pub use tremie_team::Variant;
