//! The start contract: a component process is started, describes itself, and gets its assignment.
//!
//! It is plain text, so that any language can take part. The orchestrator starts the program with
//! the environment variable [`INTERFACE_VARIABLE`] set. Both exchange lines of JSON, one
//! [`Request`] or [`Reply`] a line: requests on the component's standard input, replies on its
//! standard output. Standard error is the component's own, and lands in the run's log.
//!
//! ```text
//! orchestrator                         component
//!   {"hello": {..}}            ->
//!                              <-      {"description": {..}}   or {"refusal": {..}}
//!   {"assignment": {..}}       ->
//!                              <-      {"ready": {..}}         or {"refusal": {..}}
//!        windows run over shared memory: credit, reports, edges, frames
//!                              <-      {"saved": {..}}         at a checkpoint, if it has a state
//!                              <-      {"finished": {..}}      or {"fault": {..}}
//!   {"quit": {}}               ->      (closes its channels and exits with code 0)
//! ```
//!
//! End of input at any time means that the orchestrator is gone: the component ends at once.

pub mod checkpoint;
mod description;
mod fault;
mod frames;
pub mod signal_row;

pub use description::{
    Description, ProfileSpec, Signal, SliceSpec, VolumeSpec, VolumeWish, Watches,
};
pub use fault::{Fault, FaultKind, Injection, InjectionKind};
pub use frames::{
    CoupledComponent, CoupledExchange, FrameContent, FrameStream, RunCoupling, SentChannel,
    VolumeGrid,
};
pub use signal_row::SignalRow;

use crate::schedule::{Edge, Script};
use crate::{Problem, Role, WatchedSignal, scene::Scene};
use serde::{Deserialize, Serialize};

/// Environment variable of a program that is started as a component; its value is the interface
/// version in decimal.
pub const INTERFACE_VARIABLE: &str = "TREMIE_INTERFACE";

/// A line from the orchestrator to a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Request {
    /// Asks for the component's description, and whether it can simulate the scene.
    Hello(Box<Hello>),
    /// Gives the component its work in the run.
    Assignment(Box<Assignment>),
    /// Close everything and exit.
    Quit {},
}

/// A line from a component to the orchestrator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reply {
    /// Answers [`Request::Hello`].
    Description(Box<Description>),
    /// The input is wrong; each problem names its key.
    Refusal {
        /// The problems, one for each wrong key.
        problems: Vec<Problem>,
    },
    /// All channels are open; answers [`Request::Assignment`].
    Ready {},
    /// An observer has taken a first frame of each of its streams: from now on its channels lose
    /// nothing. (A receiver that has never taken anything can lose messages, whatever the channel.)
    Watching {},
    /// The component has looked for a peer's message for some time, in vain; said again as long as
    /// that lasts. When every component has looked after the last of them began to wait, a message
    /// was lost, and the orchestrator need not wait for the deadline to say so.
    Waiting {
        /// The peer.
        from: String,
        /// The missing message, as `state of window 7`.
        what: String,
        /// Window of the missing message.
        owed: u64,
        /// When this wait began, after everything that the component had to send before:
        /// nanoseconds of the machine's clock, comparable between processes.
        since: u64,
        /// When the last look at the channel began, by the same clock.
        looked: u64,
        /// Window that the component works on.
        window: u64,
        /// Inside a window: number of the missing message of the exchange between grains and
        /// rubber, counted so that later ones have larger numbers; else 0.
        #[serde(default)]
        turn: u64,
    },
    /// An observer took no frames for too long; the component sends it no more.
    GaveUp {
        /// The observer.
        observer: String,
        /// Reason, a sentence.
        why: String,
    },
    /// An observer is there, whatever it waits for; said again and again. One that must finish and is silent for
    /// some seconds counts as hung.
    Busy {},
    /// The wait of the last [`Reply::Waiting`] is over.
    Resumed {},
    /// The component's state at the end of a checkpoint's window is written, and the disk has it.
    Saved {
        /// The window.
        window: u64,
        /// Length of the file [bytes].
        bytes: u64,
        /// Time for which the component stood still to copy the state [ns].
        copied: u64,
    },
    /// The component's state at the end of a checkpoint's window could not be written. The
    /// component goes on.
    NotSaved {
        /// The window.
        window: u64,
        /// Reason, a sentence.
        why: String,
    },
    /// What the ranks of a component of several processes did in a window of [`Assignment::timed`].
    Ranks {
        /// The window.
        window: u64,
        /// When they began to compute it, by the machine's clock: nanoseconds since the Unix epoch.
        begin: u64,
        /// The times of each rank.
        ranks: Vec<RankTime>,
    },
    /// The last window is done and every message sent.
    Finished {
        /// Last window that the component completed.
        window: u64,
        /// Outputs that an observer wrote or lost, for the run's summary; empty for physics.
        note: String,
    },
    /// Something failed; the component ends.
    Fault(Fault),
}

/// Wall time of a rank in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RankTime {
    /// Time in which it computed [ns].
    pub compute: u64,
    /// Time in which it waited for other ranks, or sent to them [ns].
    pub wait: u64,
}

/// First request: the role, scene and parameters of the component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Interface version of the orchestrator; a component of another version refuses.
    pub interface: u32,
    /// Id of the run.
    pub run: u64,
    /// Name of the component in this run.
    pub component: String,
    /// Role that it shall take.
    pub role: Role,
    /// The scene.
    pub scene: Scene,
    /// The component's own table in the manifest, as written there (units and all).
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Threads that it may use to compute.
    pub threads: u32,
    /// Folder of the run's outputs, for observers.
    pub output: String,
}

/// Time in a run: integer ticks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Length of a tick [s].
    pub tick: f64,
    /// Ticks in a coupling window.
    pub ticks_per_window: u64,
}

impl Clock {
    /// Length of a window [s].
    pub fn window(&self) -> f64 {
        self.tick * self.ticks_per_window as f64
    }

    /// Simulated time at `ticks` [s].
    pub fn seconds(&self, ticks: u64) -> f64 {
        self.tick * ticks as f64
    }
}

/// Second request: the component's steps, edges, script and frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Assignment {
    /// Ticks and windows.
    pub clock: Clock,
    /// Number of windows in the run.
    pub windows: u64,
    /// Substeps of this component in a window (`sync_iter`).
    pub substeps: u32,
    /// Length of one of them [s].
    pub step: f64,
    /// A row of signals is kept every so many windows.
    pub rows_every: u64,
    /// Most bodies that can live at once.
    pub body_capacity: u64,
    /// Edges that this component sends or receives on; scripts index this list.
    pub edges: Vec<Edge>,
    /// Operations of each window.
    pub script: Script,
    /// Its signals that the run watches.
    #[serde(default)]
    pub watched: Vec<WatchedSignal>,
    /// Frames to send (physics) or to take (observers).
    pub frames: Vec<FrameStream>,
    /// Shared memory through which it reaches the others.
    pub transport: Transport,
    /// Faults to commit on purpose, for tests of a run's guards.
    pub injections: Vec<Injection>,
    /// The checkpoint from which the run goes on, if it does not begin.
    #[serde(default)]
    pub resume: Option<Resume>,
    /// First and last window of which a component of several ranks tells the times of each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub timed: Option<(u64, u64)>,
}

/// A checkpoint from which a run goes on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Resume {
    /// Window at whose end it was kept.
    pub window: u64,
    /// Its folder.
    pub folder: String,
    /// Observers go on with the files that they wrote, too; otherwise they begin anew.
    pub same_outputs: bool,
    /// The run begins at time zero, and the component takes bodies and contacts alone: the state is of a
    /// run of other components. Only grains are asked to.
    pub bodies_only: bool,
}

/// Names of a run's shared memory, and limits of waits.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transport {
    /// `true`: processes (`ipc`); `false`: threads of one process (`local`).
    pub between_processes: bool,
    /// Folder of the run's shared-memory bookkeeping, readable by its user only.
    pub root: String,
    /// Prefix of the names of everything that the run puts into shared memory.
    pub prefix: String,
    /// Service that carries [`crate::control::Credit`] to this component.
    pub credit_service: String,
    /// Service that carries [`crate::control::Report`] from this component.
    pub report_service: String,
    /// Most reports under way; credit never runs further ahead.
    pub report_depth: u64,
    /// Longest wait for a peer's message [s]; after it the peer counts as hung.
    pub deadline: f64,
    /// Time to poll before blocking [s].
    pub poll: f64,
}
