//! Lattice-Boltzmann fluid of Tremie: D3Q19 in place on a list of cells, moving spheres, walls,
//! mirrors, open and periodic faces.
//!
//! [`Parameters::resolve`] checks the user's choices against a scene; [`FluidLbm`] runs it. The
//! library knows no transport: give it the bodies' states, take the loads.
//!
//! # A step
//! With the bodies at the end of the step: cells that bodies cover leave the fluid and cells that
//! they uncover join it (`owners`, `refill`); all fluid cells collide and stream in one array
//! (`kernel`), where the places of populations already see to walls, mirrors and periodic faces
//! (`places`); populations that ran into bodies (`links`), curved or moving walls (`fixed`) are
//! reflected; cells at open faces get what these prescribe (`open`,
//! `extrapolation`, `reservoir`, `piston`). The momentum exchanged is the
//! load on the bodies, with the pressure in gaps that hold no cell (`gaps`). Gaps that the scene
//! declares are frozen while they are thin (`declared`), and may slip (`slip`). What bodies took from the
//! mass beyond their volume can be paid back (`mass`). Deformable surfaces are bodies whose vertices move
//! by themselves; their facets get the loads (`shape`, `surfaces`, `facet_loads`).
//!
//! # Same bits
//! Results depend neither on the number of threads nor on the vector instructions of the processor.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod axes;
mod balance;
mod batch;
mod bodies;
mod body;
mod body_memory;
mod bricks;
mod catalogue;
mod cells;
mod collision;
mod columns;
#[cfg(feature = "component")]
pub mod component;
mod compression;
mod course;
mod cover;
mod crossing;
mod cut_links;
mod declared;
mod displaced;
mod error;
mod events;
mod extrapolation;
mod facet_loads;
mod field;
mod findings;
mod fixed;
mod fluid;
mod gap_findings;
mod gap_pressure;
mod gaps;
mod grain_space;
mod grid;
mod ground;
mod halfway;
mod kernel;
mod lanes;
pub mod lattice;
mod layout;
mod leak;
mod ledger;
mod links;
mod lost;
mod mass;
#[cfg(feature = "component")]
mod meanings;

mod motion;
mod narrow;
mod observe;
mod open;
mod open_area;
mod owners;
mod parameters;
mod part_body;
mod part_extent;
mod part_gaps;
mod part_links;
mod pieces;
mod pinched;
mod piston;
mod places;
mod pockets;
mod ports;
mod probes;
mod refill;
mod reflect;
mod reservoir;
mod reservoir_findings;
mod resolution;
mod returned;
mod ridges;
mod row_ends;
mod runs;
mod scene_check;
mod shape;
mod sheet_links;
mod shell;
mod slip;
mod slots;
mod solids;
mod solver;
mod sphere;
mod sphere_links;
mod surfaces;
mod surroundings;
mod survey;
mod tally;
mod units;
mod voxels;
mod wall_distances;
mod wall_mass;
mod ways;

pub use error::FluidError;
pub use findings::{findings, limits};
pub use fluid::FluidLbm;
pub use ledger::Ledger;
pub use narrow::Narrow;
pub use observe::{Diagnostics, SliceNode};
pub use parameters::{Collision, GapPressure, OpenFaces, Parameters, Precision, Refill, Walls};
pub use part_extent::PartExtent;
pub use probes::{probe_meanings, probe_signals};
pub use reservoir::{ReservoirState, reservoir_signals};
pub use resolution::{Mended, Resolution};
pub use tremie_team::Variant;
