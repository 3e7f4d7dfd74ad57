//! The manifest as a user writes it: typed tables, every key optional.
//!
//! Keys are optional here even where a run needs them, so that a value that cannot be read can be
//! left out and the rest still be checked; the check says which required keys are missing.

mod bodies;
mod contacts;
mod course;
mod domain;
mod drag_bands;
mod forms;
mod gaps;
mod gas;
mod hoppers;
mod inlets;
mod parts;
mod polyhedra;
mod probes;
mod profiles;
mod scene;
mod slider;
mod surfaces;
mod values;
mod watch;

pub(super) use bodies::*;
pub(super) use contacts::*;
pub(super) use course::*;
pub(super) use domain::*;
pub(super) use drag_bands::*;
pub(super) use gaps::*;
pub(super) use gas::*;
pub(super) use hoppers::*;
pub(super) use inlets::*;
pub(super) use parts::*;
pub(super) use polyhedra::*;
pub(super) use probes::*;
pub(super) use profiles::*;
pub(super) use scene::*;
pub(super) use slider::*;
pub(super) use surfaces::*;
pub(super) use values::{ComponentEntry, DiameterEntry};
pub(super) use watch::*;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::num::{NonZeroU32, NonZeroU64};
use tremie_messages::Role;
use tremie_messages::schedule::Schedule;
use tremie_messages::units::Time;

/// A Tremie manifest: scene, components, schedule and outputs of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Tremie manifest")]
pub(super) struct Document {
    /// How long and in which order.
    pub run: RunTable,
    /// What is simulated.
    pub scene: SceneTable,
    /// Components by name; a string names the program.
    pub components: BTreeMap<String, ComponentEntry>,
    /// Settings by program (its file name without extension).
    pub settings: BTreeMap<String, Map<String, Value>>,
    /// What is kept of the run.
    pub outputs: OutputsTable,
    /// Watchdogs: limits of the physics, above which the run stops.
    #[serde(skip_serializing_if = "WatchTable::is_empty")]
    pub watch: WatchTable,
    /// Conditions that end the run early; any of them suffices.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stop_when: Vec<StopTable>,
}

/// How long and in which order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RunTable {
    /// Simulated time at which the run ends. Required.
    pub until: Option<Time>,
    /// How fluid and grains take turns (default: serial).
    pub schedule: Option<Schedule>,
    /// Longest wait for a peer; after it the peer counts as hung (default: 30 s).
    pub deadline: Option<Time>,
    /// Longest time for the components to describe themselves, and again to get ready (default:
    /// 60 s).
    pub start_within: Option<Time>,
    /// Seed of everything random (default: 1).
    pub seed: Option<u64>,
    /// Checkpoints, from which `tremie resume` goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub checkpoints: Option<CheckpointTable>,
}

/// Checkpoints of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct CheckpointTable {
    /// Wall time from one to the next (default: 15 min, unless there is a number of windows).
    pub every: Option<Time>,
    /// Windows from one to the next; what comes first counts.
    pub windows: Option<NonZeroU64>,
    /// Number of checkpoints that are kept; older ones are removed. With 0 there are none
    /// (default: 2).
    pub keep: Option<u32>,
}

/// A component in full.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct ComponentTable {
    /// A built-in component, or the path of any other program. Required.
    pub program: Option<String>,
    /// What it stands for (default: by name, where that is fluid, grains, rubber, viewer, recorder,
    /// fields or profiles).
    pub role: Option<Role>,
    /// Threads that it may use to compute (default: all cores for a fluid and for grains, else
    /// one). Fluid and grains try in their first steps, and now and then, whether more than one
    /// pays; results do not depend on it.
    pub threads: Option<NonZeroU32>,
    /// Substeps in a coupling window, fixed (default: as few as are stable). A rubber makes those
    /// of the grains.
    pub sync_iter: Option<NonZeroU32>,
    /// For an observer: whether physics waits, boundedly, rather than lose a frame of it
    /// (default: only for the programs `recorder`, `fields` and `profiles`).
    pub lossless: Option<bool>,
    /// Settings of this component, over those of its program.
    pub settings: Option<Map<String, Value>>,
}

/// What is kept of the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct OutputsTable {
    /// Simulated time between frames to observers (default: a 200th of the run).
    pub frames: Option<Time>,
    /// Simulated time between files of whole fields for ParaView, in OUT/fields (default: none).
    pub fields: Option<Time>,
    /// Simulated time between rows of signals.csv (default: every window, but at most 20,000 rows).
    pub signals: Option<Time>,
    /// Whether the built-in recorder takes part (default: true).
    pub record: Option<bool>,
    /// Whether the recording also keeps every message between components, for `tremie replay` and
    /// for differences that `tremie diff` finds to be told in full. It takes much room (default:
    /// false).
    pub messages: Option<bool>,
}

/// A condition that ends the run early. Exactly one of `below` and `above`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(super) struct StopTable {
    /// Which signal: `component.signal`. Required.
    pub signal: Option<String>,
    /// The run ends when the signal is below this value (in the signal's SI unit).
    pub below: Option<f64>,
    /// The run ends when the signal is above this value (in the signal's SI unit).
    pub above: Option<f64>,
    /// Simulated time before which the condition is not looked at (default: none).
    pub after: Option<Time>,
    /// Simulated time for which the condition must hold without a break (default: none).
    pub hold: Option<Time>,
}
