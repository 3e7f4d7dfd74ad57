//! Description: a component's own account of its step, signals, frames and needs.

use crate::{Finding, Limit};
use serde::{Deserialize, Serialize};

/// A component's description of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Description {
    /// Interface version that the component was built for.
    pub interface: u32,
    /// Program and version, for the log.
    pub program: String,
    /// The step that it would take: the largest that is stable and accurate, or the user's [s].
    /// `None` for observers, and for solvers that can take any step.
    pub step: Option<f64>,
    /// Cause that keeps the step from being longer, a few words: the smallest grain and its
    /// stiffness, the cell and the speed, the key that sets it. Empty where the component does not
    /// say.
    #[serde(default)]
    pub step_limit: String,
    /// Number of bodies that it brings (grains).
    pub bodies: u64,
    /// Scalars that it reports.
    pub signals: Vec<Signal>,
    /// Cuts that it can send to observers.
    pub slices: Vec<SliceSpec>,
    /// Whole fields that it can send to observers.
    #[serde(default)]
    pub volumes: Vec<VolumeSpec>,
    /// Profiles of the scene that it measures (grains).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<ProfileSpec>,
    /// A fluid sends the velocities at open faces ([`crate::PortState`]); grains take them.
    #[serde(default)]
    pub ports: bool,
    /// The component can send hashes and copies of its messages to observers that want them; the sdk
    /// does.
    #[serde(default)]
    pub tells_messages: bool,
    /// Grains can send the loads on their bodies to observers that want them; the sdk does.
    #[serde(default)]
    pub tells_loads: bool,
    /// Frames that an observer wants to see.
    #[serde(default)]
    pub watches: Watches,
    /// Unit of [`crate::control::Report::work`]: `cell updates`, `wet cells`, `points of gas`, `grain steps`.
    pub work: String,
    /// Work of one step in that unit, as far as it is known before the run; 0 where it is not.
    #[serde(default)]
    pub work_per_step: f64,
    /// Lines for the plan: resolution, dimensionless numbers, memory.
    pub notes: Vec<String>,
    /// Doubtful things, with the remedy, that are no matter of a number.
    pub warnings: Vec<String>,
    /// Findings: numbers with verdicts on how far the results can be trusted.
    #[serde(default)]
    pub findings: Vec<Finding>,
    /// Limits of its signals, judged when the run is over; those with a [`Limit::watch`] in every
    /// window.
    #[serde(default)]
    pub limits: Vec<Limit>,
    /// Its reports have a [`Place`](crate::Place) for each watched signal of its assignment, after
    /// the signals.
    #[serde(default)]
    pub tells_places: bool,
    /// Version of the state that the component keeps at a checkpoint; `None` if it cannot be kept.
    /// Another one whenever the content of its states changes.
    #[serde(default)]
    pub state: Option<u32>,
    /// Memory that the component expects to take [bytes]; 0 where it does not know.
    #[serde(default)]
    pub memory: u64,
    /// Resolution, for the summary: name and value, as `cells per diameter = 16`.
    pub resolution: std::collections::BTreeMap<String, f64>,
}

/// A scalar that a component reports.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Signal {
    /// Name, in snake case; the run calls it `component.name`.
    pub name: String,
    /// SI unit, `1` if it has none.
    pub unit: String,
    /// Meaning, a few words without a full stop; empty where a component says nothing.
    #[serde(default)]
    pub meaning: String,
    /// The signal has a value only in windows whose row is kept, and in a run's last: it takes time
    /// to measure, or is a mean from row to row. Other signals have a value in every window. Fluids
    /// and grains may have such signals; those of a fluid come after all others.
    #[serde(default)]
    pub sampled: bool,
}

impl Signal {
    /// A signal; its meaning is what `meanings` has for the last part of its name, after the last
    /// `.`.
    pub fn new(name: impl Into<String>, unit: &str, meanings: &[(&str, &str)]) -> Self {
        let name = name.into();
        let last = name.rsplit('.').next().unwrap_or_default();
        let meaning = meanings.iter().find(|(of, _)| *of == last).map(|(_, text)| *text);
        let meaning = meaning.unwrap_or_default().into();
        Self { meaning, unit: unit.into(), name, sampled: false }
    }

    /// The same, but measured only where a row is kept.
    pub fn sampled(self) -> Self {
        Self { sampled: true, ..self }
    }
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

/// A profile of the scene that a component measures.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProfileSpec {
    /// Name of the profile.
    pub name: String,
    /// Number of bins.
    pub bins: u64,
}

/// Frames that an observer wants to see. Streams that nobody wants are not set up, and cost
/// nothing.
///
/// Left out of a description, it is everything but deformable surfaces, loads, profiles, timings, hashes,
/// messages and whole fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Watches {
    /// Bodies.
    pub bodies: bool,
    /// Deformable surfaces.
    pub surfaces: bool,
    /// Loads on bodies.
    pub loads: bool,
    /// Cuts.
    pub slices: bool,
    /// Tables of profiles of grains.
    pub profiles: bool,
    /// Wall time that components take, and the schedule.
    pub timings: bool,
    /// Signals.
    pub signals: bool,
    /// Lines of the log.
    pub log: bool,
    /// Hashes of the messages between components. Only lossless observers get them.
    pub hashes: bool,
    /// All messages between components. Only lossless observers get them.
    pub messages: bool,
    /// Whole fields, this much of each.
    pub volumes: Option<VolumeWish>,
}

impl Default for Watches {
    fn default() -> Self {
        Self {
            bodies: true,
            surfaces: false,
            loads: false,
            slices: true,
            profiles: false,
            timings: false,
            signals: true,
            log: true,
            hashes: false,
            messages: false,
            volumes: None,
        }
    }
}

/// Part of a field that an observer wants.
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
