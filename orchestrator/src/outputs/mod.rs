//! What a run leaves in its folder, as far as the orchestrator writes it: the manifest as resolved,
//! the table of signals, the log and the summary; and how that table is read again.

mod columns;
mod folder;
mod log;
mod signals;
mod summary;
mod trace;

pub use columns::{Cut, Signals, UnreadableSignals};
pub use folder::{OutputError, RunFolder};
pub use log::{Level, RunLog};
pub use signals::{SignalTable, Statistics};
pub use summary::{ComponentSummary, Ending, Summary};
pub use trace::Trace;

/// The manifest as resolved.
pub const MANIFEST: &str = "manifest.toml";
/// Time series of every signal.
pub const SIGNALS: &str = "signals.csv";
/// What happened, a JSON document a line.
pub const LOG: &str = "log.jsonl";
/// When components waited and computed, where it was asked for.
pub const TRACE: &str = "trace.json";
/// Status, times, headline results.
pub const SUMMARY: &str = "summary.json";
/// Whole fields, where they were asked for; a folder, by the observer of that name.
pub const FIELDS: &str = "fields";
/// Frames, by the recorder.
pub const RECORDING: &str = "run.mcap";
