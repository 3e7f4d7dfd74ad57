//! A checked manifest: what a run shall be, in SI units, nothing left open.

use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::path::Path;
use tremie_messages::scene::Scene;
use tremie_messages::schedule::Schedule;
use tremie_messages::{Role, WatchedQuantity};

/// Most substeps that a component may make in a coupling window.
pub const MOST_SUBSTEPS: u32 = 1000;

/// Longest time for components to describe themselves, or to get ready, unless the manifest says
/// otherwise [s].
pub const START_WITHIN: f64 = 60.0;

/// Specification of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Length of the run, and order of its components.
    pub run: RunOptions,
    /// Scene that is simulated.
    pub scene: Scene,
    /// Components that take part, sorted by name.
    pub components: Vec<ComponentSpec>,
    /// Settings by program (file name without extension), also of programs that take no part.
    pub settings: BTreeMap<String, Map<String, Value>>,
    /// Outputs that are kept of the run.
    pub outputs: Outputs,
    /// Conditions that end the run early.
    pub stop_when: Vec<StopCondition>,
    /// Limits of the physics that the manifest gives; for others those of the components hold.
    pub watch: BTreeMap<WatchedQuantity, WatchLimit>,
}

/// Limit of a watched quantity, as the manifest gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WatchLimit {
    /// Above it the run stops.
    Above(f64),
    /// The quantity is not watched.
    Off,
}

/// Length of a run, order of its components, waits and seed.
#[derive(Clone, Debug, PartialEq)]
pub struct RunOptions {
    /// Simulated time at which the run ends [s].
    pub until: f64,
    /// Schedule by which fluid and grains take turns.
    pub schedule: Schedule,
    /// Longest wait for a peer [s].
    pub deadline: f64,
    /// Longest time for the components to describe themselves, and again to get ready [s].
    pub start_within: f64,
    /// Seed of everything random.
    pub seed: u64,
    /// Checkpoints that are made of it.
    pub checkpoints: Checkpoints,
}

/// Times at which a run makes checkpoints, and how many it keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checkpoints {
    /// Wall time from one to the next [s].
    pub every: Option<f64>,
    /// Windows from one to the next.
    pub windows: Option<u64>,
    /// Number that is kept; none is made for 0.
    pub keep: u32,
}

impl Default for Checkpoints {
    fn default() -> Self {
        Self { every: Some(900.0), windows: None, keep: 2 }
    }
}

/// A component of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentSpec {
    /// Name, unique in the run: letters, digits, `-` and `_`.
    pub name: String,
    /// Role that it has.
    pub role: Role,
    /// A built-in component or the path of a program.
    pub program: String,
    /// Threads that it may use to compute; `None` where the manifest leaves that to the machine.
    pub threads: Option<u32>,
    /// Substeps in a window, where the manifest fixes them.
    pub sync_iter: Option<u32>,
    /// For an observer: whether physics waits, boundedly, rather than lose a frame of it.
    pub lossless: bool,
    /// The settings of its program, with its own laid over.
    pub settings: Map<String, Value>,
}

/// Outputs that are kept of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outputs {
    /// Simulated time between frames to observers [s].
    pub frames: f64,
    /// Simulated time between files of whole fields [s]; `None`: no such files.
    pub fields: Option<f64>,
    /// Simulated time between rows of the signals' table [s]; `None`: every window, within reason.
    pub signals: Option<f64>,
    /// True if the built-in recorder takes part.
    pub record: bool,
    /// True if it keeps every message between components, too.
    pub messages: bool,
}

/// A condition that ends a run early.
#[derive(Clone, Debug, PartialEq)]
pub struct StopCondition {
    /// Name of the component.
    pub component: String,
    /// Name of its signal.
    pub signal: String,
    /// When it is met.
    pub limit: Limit,
    /// Simulated time before which it is not looked at [s].
    pub after: f64,
    /// Simulated time for which it must hold without a break [s].
    pub hold: f64,
}

/// A bound of a signal, in the signal's SI unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Met by values below.
    Below(f64),
    /// Met by values above.
    Above(f64),
}

impl Limit {
    /// True if `value` meets it.
    pub fn is_met_by(self, value: f64) -> bool {
        match self {
            Self::Below(bound) => value < bound,
            Self::Above(bound) => value > bound,
        }
    }
}

impl Spec {
    /// The component of that name.
    pub fn component(&self, name: &str) -> Option<&ComponentSpec> {
        self.components.iter().find(|component| component.name == name)
    }

    /// Simulated time between frames to an observer [s].
    pub fn interval(&self, observer: &ComponentSpec) -> f64 {
        match self.outputs.fields {
            Some(time) if observer.stem() == "fields" => time,
            _ => self.outputs.frames,
        }
    }

    /// Adds the observers that the manifest's outputs ask for: recorder, fields, profiles.
    pub fn add_output_observers(&mut self) {
        if self.outputs.record {
            self.add_observer("recorder");
        }
        if self.outputs.messages {
            for component in self.components.iter_mut().filter(|c| c.stem() == "recorder") {
                component.settings.insert("messages".into(), true.into());
            }
        }
        if self.outputs.fields.is_some() {
            self.add_observer("fields");
        }
        if !self.scene.profiles.is_empty() {
            self.add_observer("profiles");
        }
    }

    /// Adds a built-in observer under the name of its program, with the settings that the manifest
    /// has for it. Does nothing where one of that program, or anything of that name, takes part.
    pub fn add_observer(&mut self, program: &str) {
        let taken = |c: &ComponentSpec| c.name == program || c.stem() == program;
        if self.components.iter().any(taken) {
            return;
        }
        self.components.push(ComponentSpec {
            name: program.to_string(),
            role: Role::Observer,
            program: program.to_string(),
            threads: None,
            sync_iter: None,
            lossless: is_lossless_by_default(program),
            settings: self.settings.get(program).cloned().unwrap_or_default(),
        });
        self.components.sort_by(|a, b| a.name.cmp(&b.name));
    }
}

impl ComponentSpec {
    /// Its key in the manifest.
    pub fn key(&self) -> String {
        super::path::join("components", &self.name)
    }

    /// Name of the program's file without extension: how `[settings]` calls it.
    pub fn stem(&self) -> &str {
        stem(&self.program)
    }

    /// Threads that it may use on a machine of `cores`: as the manifest says, else all for a
    /// role with steps of its own, which finds out what more than one is worth; one for anything
    /// else. Results do not depend on it.
    pub fn threads_of(&self, cores: u32) -> u32 {
        self.threads.unwrap_or(if self.role.has_steps() { cores.max(1) } else { 1 })
    }
}

/// Name of a program's file without extension.
pub(super) fn stem(program: &str) -> &str {
    Path::new(program).file_stem().and_then(|stem| stem.to_str()).unwrap_or(program)
}

/// Files shall have every frame; a viewer shows the newest.
pub(super) fn is_lossless_by_default(program: &str) -> bool {
    matches!(stem(program), "recorder" | "fields" | "profiles")
}
