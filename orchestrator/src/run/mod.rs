//! A whole run, from a checked manifest to closed outputs.
//!
//! [`prepare`] starts the components, asks each for its description ([`handshake`]) and plans the
//! run. [`Prepared::execute`] hands out the assignments and runs the windows ([`run_loop`]).

mod ask_all;
pub mod changes;
mod checkpointed;
pub mod control;
mod execute;
pub mod handshake;
mod last_words;
pub mod launch;
pub mod limits;
pub mod measured_time;
pub mod monitor;
mod origin;
mod prepare;
pub mod run_loop;
mod startup_log;
mod stop_conditions;
mod watchdogs;

pub use execute::{Ended, RunCall};
pub use origin::{Origin, Takes};
pub use prepare::{Prepared, prepare, signals_of};
pub use run_loop::Change;

use crate::outputs::{ChangeRecord, OutputError};
use crate::run::handshake::NotIntroduced;
use std::ops::RangeInclusive;
use std::time::Duration;
use tremie_channels::ChannelError;
use tremie_channels::memory::NoMemory;
use tremie_messages::Problem;
use tremie_messages::start::Injection;
use tremie_state::StateError;

/// Longest time that a component which is done may take to close its channels and exit.
pub(crate) const EXIT_GRACE: Duration = Duration::from_secs(2);
/// The same, of components that have not begun.
pub(crate) const QUIT_GRACE: Duration = Duration::from_millis(300);

/// Options of a run's execution; none of them changes results.
#[derive(Clone, Debug, Default)]
pub struct Execution {
    /// Components as threads of this process.
    pub in_process: bool,
    /// Programs without their launchers: for a check where launchers are not to begin.
    pub unlaunched: bool,
    /// Faults that components shall commit: component and fault.
    pub inject: Vec<(String, Injection)>,
    /// Time that components poll before they sleep, if not the usual one.
    pub poll: Option<Duration>,
    /// Windows of which a trace is written.
    pub trace: Option<RangeInclusive<u64>>,
    /// Window at whose end the run is paused.
    pub pause_at: Option<u64>,
    /// Changes of the manifest at windows to come.
    pub changes: Vec<ChangeRecord>,
}

/// Reason why a run did not begin.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The input is wrong.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Input(Vec<Problem>),
    /// An output could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Shared memory could not be set up.
    #[error("cannot set up shared memory: {0}")]
    Channel(#[from] ChannelError),
    /// Shared memory cannot hold the run.
    #[error(transparent)]
    Memory(#[from] NoMemory),
    /// The system lets the program have too little of something.
    #[error("{0}")]
    Limit(String),
    /// The operating system refuses a place for the run's bookkeeping.
    #[error("cannot make the run's private folder below /tmp: {0}")]
    Places(std::io::Error),
    /// The operating system refuses to report Ctrl-C.
    #[error("cannot watch for Ctrl-C: {0}")]
    Signals(std::io::Error),
    /// A component did not get ready.
    #[error("{0}")]
    NotReady(String),
    /// The checkpoint does not fit the run that shall go on from it.
    #[error("the run cannot go on from {checkpoint}: {}", why.join("; "))]
    Unfit {
        /// The checkpoint's folder.
        checkpoint: String,
        /// What differs.
        why: Vec<String>,
    },
    /// The orchestrator's part of a checkpoint could not be put back.
    #[error("the orchestrator's state cannot be put back: {0}")]
    State(#[from] StateError),
    /// The user asked for the end before the first window.
    #[error("interrupted before the first window; no outputs are kept")]
    Interrupted,
}

impl From<NotIntroduced> for RunError {
    fn from(not: NotIntroduced) -> Self {
        match not {
            NotIntroduced::Interrupted => Self::Interrupted,
            NotIntroduced::Problems(problems) => Self::Input(problems),
        }
    }
}
