//! The start contract: how a component process is started, asked what it is, and told what to do.
//!
//! It is plain text, so that any language can take part. The orchestrator starts the program with
//! the environment variable [`INTERFACE_VARIABLE`] set and speaks with it in lines of JSON, one
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
//!                              <-      {"finished": {..}}      or {"fault": {..}}
//!   {"quit": {}}               ->      (closes its channels and exits with code 0)
//! ```
//!
//! End of input at any time means that the orchestrator is gone: the component ends at once.

use crate::schedule::{Edge, Script};
use crate::{Finding, Problem, Role, scene::Scene};
use serde::{Deserialize, Serialize};

/// Environment variable that tells a program that it was started as a component; its value is the
/// interface version in decimal.
pub const INTERFACE_VARIABLE: &str = "TREMIE_INTERFACE";

/// A line from the orchestrator to a component.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Request {
    /// Who are you, and can you do this?
    Hello(Box<Hello>),
    /// Do this.
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
        /// What is wrong.
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
        /// What the peer owes, as `state of window 7`.
        what: String,
        /// Window whose message the peer owes.
        owed: u64,
        /// When this wait began, after everything that the component had to send before: nanoseconds
        /// of the machine's clock, comparable between processes.
        since: u64,
        /// When the last look at the channel began, by the same clock.
        looked: u64,
        /// Window that the component works on.
        window: u64,
        /// Inside a window: which message of the exchange between grains and rubber is owed, counted so
        /// that later ones have larger numbers; else 0.
        #[serde(default)]
        turn: u64,
    },
    /// An observer took no frames for too long; the component sends it no more.
    GaveUp {
        /// The observer.
        observer: String,
        /// What failed.
        why: String,
    },
    /// An observer that was told to finish is still at it: it has taken frames since it last spoke,
    /// or begins to close its outputs. One that says nothing for some seconds counts as hung.
    Busy {},
    /// The wait of the last [`Reply::Waiting`] is over.
    Resumed {},
    /// The last window is done and every message sent.
    Finished {
        /// Last window that the component completed.
        window: u64,
        /// What an observer wrote or lost, for the run's summary; empty for physics.
        note: String,
    },
    /// Something failed; the component ends.
    Fault(Fault),
}

/// First request: what the component will take part in.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// Interface version of the orchestrator; a component of another version refuses.
    pub interface: u32,
    /// Id of the run.
    pub run: u64,
    /// Name of the component in this run.
    pub component: String,
    /// What it shall stand for.
    pub role: Role,
    /// What is simulated.
    pub scene: Scene,
    /// The component's own table in the manifest, as written there (units and all).
    pub parameters: serde_json::Map<String, serde_json::Value>,
    /// Threads that it may use to compute.
    pub threads: u32,
    /// Folder of the run's outputs, for observers.
    pub output: String,
}

/// What a component is and needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Interface version that the component was built for.
    pub interface: u32,
    /// Program and version, for the log.
    pub program: String,
    /// The step that it would take: the largest that is stable and accurate, or the user's [s].
    /// `None` for observers, and for solvers that can take any step.
    pub step: Option<f64>,
    /// Number of bodies that it brings (grains).
    pub bodies: u64,
    /// Scalars that it reports every window.
    pub signals: Vec<Signal>,
    /// Cuts that it can send to observers.
    pub slices: Vec<SliceSpec>,
    /// Whole fields that it can send to observers.
    #[serde(default)]
    pub volumes: Vec<VolumeSpec>,
    /// Of a fluid: whether it tells the velocities at open faces ([`crate::PortState`]); of grains: whether
    /// they take them.
    #[serde(default)]
    pub ports: bool,
    /// For an observer: what it wants to see.
    #[serde(default)]
    pub watches: Watches,
    /// What one unit of [`crate::control::Report::work`] is: `cell updates`, `grain steps`.
    pub work: String,
    /// Lines for the plan: resolution, dimensionless numbers, memory.
    pub notes: Vec<String>,
    /// Doubtful things, with the remedy, that are no matter of a number.
    pub warnings: Vec<String>,
    /// Numbers that say how far the results can be trusted, each with a verdict.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// Memory that the component expects to take [bytes]; 0 where it does not know.
    #[serde(default)]
    pub memory: u64,
    /// Resolution, for the summary: name and value, as `cells per diameter = 16`.
    pub resolution: std::collections::BTreeMap<String, f64>,
}

/// A scalar that a component reports every window.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signal {
    /// Name, in snake case; the run calls it `component.name`.
    pub name: String,
    /// SI unit, `1` if it has none.
    pub unit: String,
}

/// A plane cut that a component can send.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SliceSpec {
    /// Name, unique in the component.
    pub name: String,
    /// Number of nodes.
    pub nodes: u64,
}

/// A lattice whose nodes a component can send.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeSpec {
    /// Name, unique in the component.
    pub name: String,
    /// Position of the first node [m].
    pub origin: [f64; 3],
    /// Step to the next node along each axis [m].
    pub step: [f64; 3],
    /// Number of nodes along each axis.
    pub count: [u64; 3],
}

/// What an observer wants to see. Streams that nobody wants are not set up, and cost nothing.
///
/// Left out of a description, it is everything but whole fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Watches {
    /// Bodies.
    pub bodies: bool,
    /// Cuts.
    pub slices: bool,
    /// Signals.
    pub signals: bool,
    /// Lines of the log.
    pub log: bool,
    /// Whole fields, this much of each.
    pub volumes: Option<VolumeWish>,
}

impl Default for Watches {
    fn default() -> Self {
        Self { bodies: true, slices: true, signals: true, log: true, volumes: None }
    }
}

/// How much of a field an observer wants.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct VolumeWish {
    /// Every so many nodes along each axis; 0 counts as 1.
    pub stride: u64,
    /// Most nodes in a frame: the stride grows until they are no more.
    pub most_nodes: Option<u64>,
    /// Corners of the box whose nodes are wanted [m]: all nodes, if there is none.
    pub region: Option<[[f64; 3]; 2]>,
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

/// Second request: what the component has to do.
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
    /// Most bodies that can live at once.
    pub body_capacity: u64,
    /// Edges that this component sends or receives on; scripts index this list.
    pub edges: Vec<Edge>,
    /// What to do in each window.
    pub script: Script,
    /// Frames to send (physics) or to take (observers).
    pub frames: Vec<FrameStream>,
    /// How to reach the others.
    pub transport: Transport,
    /// Faults to commit on purpose, for tests of a run's guards.
    pub injections: Vec<Injection>,
}

/// Where shared memory of a run is found, and how long to wait.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// How long to poll before blocking [s].
    pub poll: f64,
}

/// What a frame holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrameContent {
    /// [`crate::frame::BodySample`]s of all bodies.
    Bodies,
    /// A cut of that name: [`crate::frame::SliceNode`]s.
    Slice(String),
    /// Nodes of a lattice: [`crate::frame::SliceNode`]s.
    Volume(VolumeGrid),
    /// The component's signals, in the order of its description, with that order given here.
    Signals(Vec<Signal>),
    /// Lines of the log (sent by the orchestrator).
    Log,
}

/// Nodes of a lattice, the same number apart along each axis.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct VolumeGrid {
    /// Name of the volume in its component's description.
    pub name: String,
    /// Node of the lattice where the grid begins.
    pub first: [u64; 3],
    /// Every so many nodes of the lattice, along each axis.
    pub stride: u64,
    /// Number of nodes along each axis.
    pub count: [u64; 3],
}

impl VolumeGrid {
    /// The part of `volume` that an observer wants; `None` if no node of it is.
    ///
    /// Nodes that a stride leaves out are left out evenly at both ends.
    pub fn new(volume: &VolumeSpec, wish: &VolumeWish) -> Option<Self> {
        let ranges: Vec<[u64; 2]> =
            (0..3).map(|axis| wanted(volume, wish, axis)).collect::<Option<_>>()?;
        let grid = |stride: u64| {
            let count = std::array::from_fn(|a| (ranges[a][1] - ranges[a][0]).div_ceil(stride));
            let left_out = |a: usize| ranges[a][1] - ranges[a][0] - 1 - (count[a] - 1) * stride;
            let first = std::array::from_fn(|a| ranges[a][0] + left_out(a) / 2);
            Self { name: volume.name.clone(), first, stride, count }
        };
        let most = wish.most_nodes.unwrap_or(u64::MAX).max(1);
        let longest = ranges.iter().map(|[begin, end]| end - begin).max()?;
        // A stride of the longest edge leaves one node.
        (wish.stride.max(1)..=longest.max(wish.stride)).map(grid).find(|grid| grid.nodes() <= most)
    }

    /// Number of nodes.
    pub fn nodes(&self) -> u64 {
        self.count.iter().product()
    }

    /// Node of the lattice that node `at` of the grid is.
    pub fn lattice_node(&self, at: [u64; 3]) -> [u64; 3] {
        std::array::from_fn(|a| self.first[a] + self.stride * at[a])
    }
}

/// Nodes along an axis that lie in the wanted region, as `[begin, end]`; `None` if there are none.
fn wanted(volume: &VolumeSpec, wish: &VolumeWish, axis: usize) -> Option<[u64; 2]> {
    let count = volume.count[axis];
    let (begin, end) = match wish.region {
        None => (0, count),
        Some([min, max]) => {
            let nodes = |x: f64| (x - volume.origin[axis]) / volume.step[axis];
            // Half a millionth of a step of slack: a region may end on a node.
            let begin = (nodes(min[axis]) - 5e-7).ceil().max(0.0) as u64;
            let end = (nodes(max[axis]) + 5e-7).floor() + 1.0;
            (begin, (end.max(0.0) as u64).min(count))
        }
    };
    (begin < end).then_some([begin, end])
}

/// A stream of frames from a component to an observer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrameStream {
    /// Sending component.
    pub from: String,
    /// Receiving observer.
    pub to: String,
    /// What a frame holds.
    pub content: FrameContent,
    /// A frame every so many windows, one of the start exchange, and one of the run's last window.
    pub every: u64,
    /// `true`: the sender waits (boundedly) for room; `false`: the oldest frame gives way.
    pub lossless: bool,
    /// Name of the shared-memory service.
    pub service: String,
    /// Most values in a frame.
    pub capacity: u64,
    /// Most frames under way.
    pub depth: u64,
}

/// What went wrong in a component, both sides named.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Component that noticed.
    pub noticed_by: String,
    /// Component that is to blame, if that is known; else the one that noticed.
    pub blamed: String,
    /// Window in which it happened.
    pub window: u64,
    /// What was expected and what was found, a sentence.
    pub message: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} failed at window {}: {}", self.blamed, self.window, self.message)?;
        if self.noticed_by != self.blamed {
            write!(f, " (noticed by {})", self.noticed_by)?;
        }
        Ok(())
    }
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultKind {
    /// A message carries another stamp than the schedule foretells.
    Stamp,
    /// A message holds another number of values, or bodies of other ids, than foretold.
    Count,
    /// A number is not finite.
    NotFinite,
    /// A message was sent, so its sender says, and never arrived.
    Lost,
    /// A peer's message did not come in time.
    Deadline,
    /// A component made more or fewer substeps than assigned.
    Substeps,
    /// The solver itself failed.
    Solver,
    /// A channel failed.
    Channel,
    /// A component's process ended without a word.
    Exit,
    /// The start contract was broken.
    Contract,
}

/// A fault to commit on purpose in one window.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Injection {
    /// What to do.
    pub kind: InjectionKind,
    /// In which window.
    pub window: u64,
}

/// Faults that a component can be made to commit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InjectionKind {
    /// Do not send.
    Drop,
    /// Send twice.
    Duplicate,
    /// Send with the stamp of the window before.
    Stale,
    /// Send one value too few.
    Count,
    /// Send a value that is not a number.
    Nan,
    /// Stop doing anything, alive.
    Hang,
    /// Exit with code 0 in the middle.
    Exit,
    /// End by SIGKILL.
    Kill,
    /// Make one substep too many.
    SubstepMore,
    /// Make one substep too few.
    SubstepLess,
}

impl InjectionKind {
    /// All kinds, with their names.
    pub const ALL: [(InjectionKind, &'static str); 10] = [
        (InjectionKind::Drop, "drop"),
        (InjectionKind::Duplicate, "duplicate"),
        (InjectionKind::Stale, "stale"),
        (InjectionKind::Count, "count"),
        (InjectionKind::Nan, "nan"),
        (InjectionKind::Hang, "hang"),
        (InjectionKind::Exit, "exit"),
        (InjectionKind::Kill, "kill"),
        (InjectionKind::SubstepMore, "substep-more"),
        (InjectionKind::SubstepLess, "substep-less"),
    ];
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice(count: [u64; 3]) -> VolumeSpec {
        VolumeSpec { name: "lattice".into(), origin: [0.5; 3], step: [1.0; 3], count }
    }

    #[test]
    fn a_whole_lattice_is_itself() {
        let grid = VolumeGrid::new(&lattice([4, 5, 6]), &VolumeWish::default()).unwrap();
        assert_eq!((grid.first, grid.stride, grid.count), ([0; 3], 1, [4, 5, 6]));
    }

    #[test]
    fn the_stride_grows_until_nodes_fit_and_leaves_out_evenly() {
        let wish = VolumeWish { most_nodes: Some(100_000), ..Default::default() };
        let grid = VolumeGrid::new(&lattice([110, 110, 176]), &wish).unwrap();
        assert_eq!((grid.stride, grid.count), (3, [37, 37, 59]));
        assert_eq!(grid.first, [0, 0, 0]);
        assert_eq!(grid.lattice_node([36, 36, 58]), [108, 108, 174]);
        let wish = VolumeWish { stride: 4, ..Default::default() };
        let grid = VolumeGrid::new(&lattice([8, 7, 1]), &wish).unwrap();
        assert_eq!((grid.first, grid.count), ([1, 1, 0], [2, 2, 1]));
        let one = VolumeWish { most_nodes: Some(1), ..Default::default() };
        assert_eq!(VolumeGrid::new(&lattice([8, 7, 1]), &one).unwrap().nodes(), 1);
    }

    #[test]
    fn a_region_takes_the_nodes_in_it() {
        let region = |min, max| VolumeWish { region: Some([min, max]), ..Default::default() };
        let grid = VolumeGrid::new(&lattice([10; 3]), &region([2.5, -9.0, 3.6], [4.5, 99.0, 4.4]));
        assert!(grid.is_none(), "no node lies between 3.6 and 4.4 along z");
        let wish = region([2.5, -9.0, 3.0], [4.5, 99.0, 4.9]);
        let grid = VolumeGrid::new(&lattice([10; 3]), &wish).unwrap();
        assert_eq!((grid.first, grid.count), ([2, 0, 3], [3, 10, 2]));
    }
}
