//! What checkpoints of a run are of, and whether one fits a run that shall go on from it.

use crate::outputs::CheckpointRecord;
use crate::run::origin::Origin;
use crate::run::run_loop::component_record;
use crate::run::{Prepared, RunError};
use std::path::Path;
use tremie_messages::{INTERFACE_VERSION, Role};
use tremie_sdk::program_name;

/// Kind of processor and system: states are arrays as they lie in memory, and bits of results are
/// promised on one kind only.
fn machine() -> String {
    format!("{} {}", std::env::consts::ARCH, std::env::consts::OS)
}

impl Prepared {
    /// What checkpoints of the run are of; window and time are those of none.
    pub(super) fn checkpoint_record(&self, programs: &Path) -> CheckpointRecord {
        let described = self.plan.components.iter().zip(&self.descriptions);
        let components = described.filter_map(|(component, description)| {
            let record =
                component_record(&description.program, description.state?, component.substeps);
            Some((component.name.clone(), record))
        });
        CheckpointRecord {
            tremie: env!("CARGO_PKG_VERSION").into(),
            interface: INTERFACE_VERSION,
            machine: machine(),
            window: 0,
            time: 0.0,
            made_for: None,
            clock: self.plan.clock,
            programs: std::path::absolute(programs).unwrap_or_else(|_| programs.to_path_buf()),
            components: components.collect(),
        }
    }

    /// Checks that a run of this plan can begin from a checkpoint.
    ///
    /// # Errors
    /// Everything that differs.
    pub(super) fn check_fit(&self, from: Origin<'_>) -> Result<(), RunError> {
        let record = &from.checkpoint.record;
        let mut why = Vec::new();
        let mut compare = |what: &str, kept: String, now: String| {
            if kept != now {
                why.push(format!("{what}: it was made with {kept}, this run has {now}"));
            }
        };
        compare("machine", record.machine.clone(), machine());
        if from.window().is_some() {
            let window = |window: f64| format!("windows of {window:e} s");
            compare("time step", window(record.clock.window()), window(self.plan.clock.window()));
        }
        let described = self.plan.components.iter().zip(&self.descriptions);
        for (component, description) in described.filter(|(c, _)| from.resume(c.role).is_some()) {
            let name = &component.name;
            let now = say(program_name(&description.program), description.state);
            match record.components.get(name) {
                None if component.role == Role::Observer => {}
                None => compare(name, "no such component".into(), now),
                Some(kept) => {
                    compare(name, say(program_name(&kept.program), Some(kept.state)), now);
                    if from.window().is_some() {
                        let steps = |substeps: u32| format!("{substeps} steps in a window");
                        compare(name, steps(kept.substeps), steps(component.substeps));
                    }
                }
            }
        }
        if from.window().is_some_and(|window| window >= self.plan.windows) {
            why.push(format!(
                "it is of window {}, and the run ends at window {}: make it longer, as with --until",
                record.window, self.plan.windows
            ));
        }
        if why.is_empty() {
            return Ok(());
        }
        Err(RunError::Unfit { checkpoint: from.checkpoint.folder().display().to_string(), why })
    }
}

/// A program that keeps its state, or none.
fn say(program: &str, state: Option<u32>) -> String {
    match state {
        Some(state) => format!("{program}, state version {state}"),
        None => format!("{program}, which keeps no state"),
    }
}
