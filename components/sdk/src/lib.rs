//! The kit for authors of Tremie components.
//!
//! Implement [`Fluid`], [`Grains`], [`Rubber`] or [`Observer`], and call [`main`] of it, as
//! `tremie_sdk::main::<AsFluid<Mine>>()`. The sdk does the rest: the start contract, shared memory,
//! stamps, deadlines, frames for observers, and the guards that turn every failure into a fault
//! with both sides named.
//!
//! `examples/minimal-fluid` is a whole fluid of about a hundred lines.

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod benchmark;
mod context;
mod finite;
mod fluid;
mod frames;
mod grains;
pub mod idle;
mod impulse;
mod keep;
mod kept_file;
mod lagged_loads;
pub mod line;
mod observe;
pub mod observer;
pub mod parameters;
mod place_teller;
mod player;
mod ports;
mod program;
mod role_adapter;
mod roles;
mod rubber;
mod sent;
mod serve;
pub mod setup;
mod stop;
mod substep_coupling;

pub use context::{credit_spec, report_spec};
pub use fluid::AsFluid;
pub use frames::frame_spec;
pub use grains::AsGrains;
pub use keep::program_name;
pub use kept_file::{check_length, kept_file, sync};
pub use line::ControlPipe;
pub use observe::AsObserver;
pub use observer::{Moment, Observer, ObserverError, own_file};
pub use player::{RecordedMessage, RecordedMessages, play_recorded};
pub use ports::edge_spec;
pub use program::{Participant, log_line, main, main_of, number_of, run};
pub use roles::{Fluid, Grains, Rubber, SolverError};
pub use rubber::AsRubber;
pub use sent::CopiedMessage;
pub use setup::Setup;
pub use tremie_messages as messages;
pub use tremie_state as state;
