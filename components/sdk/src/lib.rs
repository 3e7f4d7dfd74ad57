//! What the author of a Tremie component needs.
//!
//! Implement [`Fluid`], [`Grains`], [`Rubber`] or [`Observer`], and call [`main_fluid`] (or its like) from
//! `main`. The sdk does the rest: the start contract, shared memory, stamps, deadlines, frames for
//! observers, and the guards that turn every failure into a fault with both sides named.
//!
//! `examples/minimal-fluid` is a whole fluid of about a hundred lines.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod benchmark;
mod context;
mod finite;
mod fluid;
mod frames;
mod grains;
mod impulse;
mod lagged_loads;
pub mod line;
mod observe;
pub mod observer;
pub mod parameters;
mod ports;
mod program;
mod role_adapter;
mod roles;
mod rubber;
mod serve;
pub mod setup;
mod stop;
mod substep_coupling;

pub use context::{credit_spec, report_spec};
pub use frames::frame_spec;
pub use line::ControlPipe;
pub use observer::{Moment, Observer, ObserverError, own_file};
pub use ports::edge_spec;
pub use program::{
    log_line, main_fluid, main_grains, main_observer, main_of, main_rubber, run_fluid, run_grains,
    run_observer, run_rubber,
};
pub use roles::{Fluid, Grains, Rubber, SolverError};
pub use setup::Setup;
pub use tremie_messages as messages;
