//! Outputs of a run in its folder that the orchestrator writes: the manifest as resolved, the table
//! of signals, the log and the summary. `tremie-results` reads the table again.

mod breach;
mod checkpoint_folder;
mod folder;
mod input_copies;
mod judged_finding;
mod log;
mod rank_times;
mod schedule_timing;
mod signals;
mod steering_record;
mod summary;
mod trace;

pub use breach::{Breach, with_unit};
pub use checkpoint_folder::{
    CheckpointRecord, ComponentRecord, LaterCheckpoints, NoCheckpoint, UnfinishedCheckpoint,
    WholeCheckpoint, remove_old_checkpoints, remove_unfinished_checkpoints,
};
pub use folder::{OutputError, RunFolder};
pub use input_copies::copy_inputs;
pub use judged_finding::{JudgedFinding, WHOLE};
pub use log::{LogLevel, RunLog};
pub use rank_times::{RankShares, RankTimes};
pub use schedule_timing::{ScheduleTiming, Worked};
pub use signals::{SignalRow, SignalTable, Statistics};
pub use steering_record::{ChangeRecord, forget_changes, read_changes, record_change};
pub use summary::{ComponentSummary, ComponentTotals, Ending, Summary};
pub use trace::Trace;
pub use tremie_results::SIGNALS;

/// The manifest as resolved.
pub const MANIFEST: &str = "manifest.toml";
/// The scene as components were given it: who reads the run later needs no file that the manifest names.
pub const SCENE: &str = "scene.json";
/// The manifest with which a run began, where it was changed later.
pub const BEGUN: &str = "begun.toml";
/// The changes, a JSON document a line.
pub const STEERING: &str = "steering.jsonl";
/// The log, a JSON document a line.
pub const LOG: &str = "log.jsonl";
/// The trace of waiting and computing, where it was asked for.
pub const TRACE: &str = "trace.json";
/// Status, times, headline results.
pub const SUMMARY: &str = "summary.json";
/// Whole fields, where they were asked for; a folder, by the observer of that name.
pub const FIELDS: &str = "fields";
/// Frames, by the recorder.
pub const RECORDING: &str = "run.mcap";
/// What Slurm was given of the run, and what its jobs said; a folder, also of a study.
pub const SLURM: &str = "slurm";
