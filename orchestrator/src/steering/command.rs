//! Commands to a run in progress, and its answers.

use crate::terminal::Progress;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A command of a user to a run in progress.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "command", deny_unknown_fields)]
pub enum SteeringCommand {
    /// Say how far the run is.
    Status {},
    /// Stop between two windows.
    Pause {},
    /// Make so many windows more, then stop between two windows.
    Step {
        /// Number of windows.
        windows: u64,
    },
    /// Go on after a pause.
    Continue {},
    /// Make a checkpoint now.
    Checkpoint {},
    /// Change values of the manifest from the next window on.
    Set {
        /// Keys and values, as `--set` takes them.
        changes: Vec<(String, String)>,
    },
    /// End in order, as Ctrl-C does.
    Stop {},
}

impl SteeringCommand {
    /// The words by which the program gives it to the run with outputs in `out`.
    pub fn words(&self, out: &Path) -> Vec<OsString> {
        let word = |word: &str| OsString::from(word);
        let mut words = match self {
            Self::Status {} => vec![word("attach"), word("--json")],
            Self::Pause {} => vec![word("pause")],
            Self::Step { windows } => vec![word("step"), word(&windows.to_string())],
            Self::Continue {} => vec![word("continue")],
            Self::Checkpoint {} => vec![word("checkpoint")],
            Self::Set { changes } => {
                let changes = changes.iter().map(|(key, value)| word(&format!("{key}={value}")));
                std::iter::once(word("set")).chain(changes).chain([word("--run")]).collect()
            }
            Self::Stop {} => vec![word("stop")],
        };
        words.push(out.into());
        words
    }
}

/// Answer of a run to a command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "answer")]
pub enum Answer {
    /// How far the run is.
    Status(Box<RunStatus>),
    /// The command was obeyed.
    Done {
        /// What the run did.
        text: String,
        /// Window from whose end on it counts.
        window: u64,
    },
    /// The command was not obeyed.
    Refused {
        /// Why, and what to do.
        why: String,
    },
}

/// What a run in progress does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunState {
    /// Components get ready.
    Starting,
    /// Windows are made.
    Running,
    /// It stands between two windows, or will when those that were granted are made.
    Paused,
    /// The last window is fixed.
    Ending,
}

impl RunState {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Starting => "starting",
            Self::Running => "running",
            Self::Paused => "paused",
            Self::Ending => "ending",
        }
    }
}

/// How far a run is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunStatus {
    /// Number of the run, in hexadecimal.
    pub run: String,
    /// What it does.
    pub state: RunState,
    /// Folder of its outputs, an absolute path.
    pub out: PathBuf,
    /// Its manifest.
    pub manifest: PathBuf,
    /// Process id of its orchestrator.
    pub process: u32,
    /// Window of its newest checkpoint.
    pub checkpoint: Option<u64>,
    /// Windows, rates, waits.
    pub progress: Progress,
}
