//! `tremie replay`: one component of a recorded run, against the recorded messages of the others.
//!
//! The run is an ordinary one, of the same manifest: players stand for the other components, which describe
//! themselves as those did, so that plan and schedule are the same. A player sends what was recorded, and
//! ends the run where something else comes than came then.
//!
//! Users may change a run in progress. A replay makes their changes at the same windows: there it takes a
//! checkpoint of its own, and goes on from that with the changed manifest, as the run did.

use crate::manifest::{self, Checkpoints, Manifest, ManifestErrors};
use crate::outputs::{
    BEGUN, ChangeRecord, Ending, MANIFEST, NoCheckpoint, OutputError, RECORDING, RunFolder,
    STEERING, WholeCheckpoint, read_changes,
};
use crate::registry::{PLAYER, ReadError, Recording};
use crate::run::{Ended, Execution, Origin, Prepared, RunCall, RunError, Takes, prepare};
use crate::terminal::Terminal;
use serde_json::{Map, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use tremie_messages::Role;
use tremie_messages::finding::short;
use tremie_messages::start::{Description, Fault, FaultKind};

/// What is replayed, and how.
#[derive(Debug)]
pub struct ReplayOrder<'a> {
    /// Folder of the recorded run.
    pub run: &'a Path,
    /// The component that runs.
    pub component: &'a str,
    /// Window of the checkpoint from which it goes on; from the start, if there is none.
    pub at: Option<u64>,
    /// Changes to the manifest's values.
    pub sets: &'a [(String, String)],
    /// Folder in which programs are looked for first, if it is not that of the run's checkpoints.
    pub programs: Option<&'a Path>,
    /// Folder of the replay's own outputs; none are kept otherwise.
    pub out: Option<&'a Path>,
    /// Components as threads of this process.
    pub in_process: bool,
}

/// Why a run was not replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The manifest cannot be read.
    #[error("{0}")]
    Manifest(Box<ManifestErrors>),
    /// The order does not fit the run.
    #[error("{0}")]
    Input(String),
    /// There is no such checkpoint.
    #[error(transparent)]
    Checkpoint(#[from] NoCheckpoint),
    /// The recording cannot be read.
    #[error(
        "{path}: {error}\nOUT is the folder of a run that was recorded with outputs.messages = true"
    )]
    Recording {
        /// The recording.
        path: String,
        /// What is wrong with it.
        error: ReadError,
    },
    /// A run could not begin.
    #[error("{0}")]
    Run(RunError, Box<Manifest>),
}

/// A run, replayed.
#[derive(Debug)]
pub struct Replayed {
    /// The window before the first that was made.
    pub from: u64,
    /// The last window of the recording.
    pub last: u64,
    /// The last window that was made and found to be as recorded.
    pub windows: u64,
    /// How it ended.
    pub ending: Ending,
}

impl Replayed {
    /// The first message that is another than the recorded one; `None` if all were the same.
    pub fn difference(&self) -> Option<&Fault> {
        match &self.ending {
            Ending::Failed { fault, .. } if fault.kind == FaultKind::Replay => Some(fault),
            _ => None,
        }
    }

    /// True if every message was the recorded one.
    pub fn is_same(&self) -> bool {
        matches!(self.ending, Ending::Completed)
    }
}

/// Replays a component.
///
/// # Errors
/// See [`ReplayError`]. Other messages than the recorded ones, and faults of the component, are no errors of
/// this function.
pub fn replay(
    order: &ReplayOrder<'_>,
    terminal: &mut Terminal,
    interrupts: &AtomicUsize,
) -> Result<Replayed, ReplayError> {
    let from = order.at.map(|at| WholeCheckpoint::find(order.run, Some(at))).transpose()?;
    let begun = HeldManifests::read(order, from)?;
    let first = begun.from.as_ref().map_or(0, |from| from.record.window);
    let manifest = begun.at(first)?;
    let recording = RecordedRun::open(order, &manifest)?;
    let programs = match order.programs {
        Some(folder) => folder.to_path_buf(),
        None => WholeCheckpoint::find(order.run, None)
            .map_or_else(|_| PathBuf::new(), |checkpoint| checkpoint.record.programs),
    };
    let home =
        tempfile::tempdir().map_err(|error| run_error(RunError::Places(error), &manifest))?;
    let folder = order.out.unwrap_or(home.path());
    let claimed = RunFolder::claim(folder);
    let mut out = claimed.map_err(|error: OutputError| run_error(error.into(), &manifest))?;
    let mut from = None;
    loop {
        let at = from.as_ref().map_or(first, |from: &WholeCheckpoint| from.record.window);
        let leg = Leg {
            order,
            manifest: begun.at(at)?,
            recording: &recording,
            programs: &programs,
            changes: begun.after(at, recording.last),
            from: match (&from, &begun.from) {
                (Some(checkpoint), _) => Some(Origin { checkpoint, takes: Takes::Outputs }),
                (None, Some(checkpoint)) => Some(Origin { checkpoint, takes: Takes::States }),
                (None, None) => None,
            },
        };
        let due = leg.due();
        let summary = leg.carry_out(&mut out, terminal, interrupts)?.close();
        // Whatever became of the window after it, with the manifest of before.
        let is_wanted = interrupts.load(Ordering::Relaxed) == 0;
        let changed =
            due.filter(|_| is_wanted).map(|at| WholeCheckpoint::find(out.path(), Some(at)));
        let Some(Ok(changed)) = changed else {
            let (last, windows, ending) = (recording.last, summary.windows, summary.ending);
            return Ok(Replayed { from: first, last, windows, ending });
        };
        out = RunFolder::reclaim(out.path()).map_err(|error| run_error(error.into(), &manifest))?;
        from = Some(changed);
    }
}

/// The manifests of a run that its users changed while it was in progress.
struct HeldManifests<'a> {
    order: &'a ReplayOrder<'a>,
    /// The checkpoint from which the replay begins.
    from: Option<WholeCheckpoint>,
    /// The file of the manifest that held before the first of the changes, where the run began.
    file: PathBuf,
    /// Changes from the begin on, in the order of their windows.
    changes: Vec<ChangeRecord>,
}

impl<'a> HeldManifests<'a> {
    fn read(
        order: &'a ReplayOrder<'a>,
        from: Option<WholeCheckpoint>,
    ) -> Result<Self, ReplayError> {
        let (record, begun) = (order.run.join(STEERING), order.run.join(BEGUN));
        let mut changes = match record.exists() {
            true => read_changes(&record).map_err(ReplayError::Input)?,
            false => Vec::new(),
        };
        // The manifest in a checkpoint is that before a change which begins there.
        let window = from.as_ref().map_or(0, |from| from.record.window);
        changes.retain(|change| change.window >= window);
        let file = if begun.exists() { begun } else { order.run.join(MANIFEST) };
        Ok(Self { order, from, file, changes })
    }

    /// The manifest that holds in the window after `window`; the user's values last.
    fn at(&self, window: u64) -> Result<Manifest, ReplayError> {
        let made = self.changes.iter().filter(|change| change.window <= window);
        let sets: Vec<_> =
            made.flat_map(|change| &change.set).chain(self.order.sets).cloned().collect();
        let manifest = match &self.from {
            Some(from) => manifest::parse(&from.manifest_file(), from.manifest.clone(), &sets),
            None => manifest::load(&self.file, &sets),
        };
        let mut manifest = manifest.map_err(|errors| ReplayError::Manifest(errors.into()))?;
        let spec = &mut manifest.spec;
        // Nobody watches, the end is that of the recording, and changes alone need checkpoints.
        spec.components.retain(|component| component.role != Role::Observer);
        spec.stop_when.clear();
        spec.run.checkpoints = Checkpoints { every: None, windows: None, keep: 1 };
        Ok(manifest)
    }

    /// Changes after `window` and before the `last`.
    fn after(&self, window: u64, last: u64) -> Vec<ChangeRecord> {
        let is_due = |change: &&ChangeRecord| change.window > window && change.window < last;
        self.changes.iter().filter(is_due).cloned().collect()
    }
}

/// A part of a replay in which the manifest stays as it is.
struct Leg<'a> {
    order: &'a ReplayOrder<'a>,
    manifest: Manifest,
    recording: &'a RecordedRun,
    programs: &'a Path,
    /// Changes that end this leg and later ones.
    changes: Vec<ChangeRecord>,
    from: Option<Origin<'a>>,
}

impl Leg<'_> {
    /// Window of the change that ends this leg.
    fn due(&self) -> Option<u64> {
        self.changes.first().map(|change| change.window)
    }

    fn carry_out(
        &self,
        out: &mut RunFolder,
        terminal: &mut Terminal,
        interrupts: &AtomicUsize,
    ) -> Result<Ended, ReplayError> {
        let Self { order, manifest, recording, programs, .. } = self;
        let failed = |error| run_error(error, manifest);
        let execution = Execution {
            in_process: order.in_process,
            changes: self.changes.clone(),
            ..Execution::default()
        };
        let described = prepare(manifest, programs, out.path(), &execution, interrupts);
        let descriptions = dismissed(described.map_err(failed)?);
        let played = self.with_players(&descriptions);
        let prepared = prepare(&played, programs, out.path(), &execution, interrupts);
        let mut prepared = prepared.map_err(failed)?;
        if let Err(why) = recording.fit(&mut prepared) {
            prepared.dismiss();
            return Err(ReplayError::Input(why));
        }
        let executed = prepared.execute(RunCall {
            manifest: &played,
            out,
            execution: &execution,
            terminal,
            interrupts,
            programs,
            from: self.from,
        });
        executed.map_err(failed)
    }

    /// The manifest with players in place of all components but one.
    fn with_players(&self, descriptions: &[Description]) -> Manifest {
        let mut played = self.manifest.clone();
        for (spec, description) in played.spec.components.iter_mut().zip(descriptions) {
            if spec.name != self.order.component {
                spec.program = PLAYER.into();
                spec.settings = Map::from_iter([
                    ("recording".into(), self.recording.path.to_string_lossy().into()),
                    ("description".into(), json!(description)),
                    ("last_compared".into(), json!(self.due())),
                ]);
            }
        }
        played
    }
}

fn run_error(error: RunError, manifest: &Manifest) -> ReplayError {
    ReplayError::Run(error, Box::new(manifest.clone()))
}

/// The recording of the run.
struct RecordedRun {
    path: PathBuf,
    window: f64,
    /// Its last window.
    last: u64,
}

impl RecordedRun {
    /// Opens the recording, and checks that it has what a replay needs.
    fn open(order: &ReplayOrder<'_>, manifest: &Manifest) -> Result<Self, ReplayError> {
        let file = order.run.join(RECORDING);
        let path = std::path::absolute(&file).unwrap_or(file);
        let unreadable = |error| ReplayError::Recording { path: path.display().to_string(), error };
        let open = || Recording::open(&path).map_err(unreadable);
        let recording = open()?;
        let physics = manifest.spec.components.iter().filter(|c| c.role != Role::Observer);
        let names: Vec<&str> = physics.map(|component| component.name.as_str()).collect();
        if !names.contains(&order.component) {
            return Err(ReplayError::Input(format!(
                "the run has no component \"{}\" of the physics, expected one of {}",
                order.component,
                names.join(", ")
            )));
        }
        if let Some(name) = names.iter().find(|name| !recording.has_messages(name)) {
            return Err(ReplayError::Input(format!(
                "{} has no messages of {name}: record the run with outputs.messages = true, of components that \
                 send observers their messages, as all with the sdk do",
                path.display()
            )));
        }
        let window = recording.clock().window();
        let own = format!("/messages/{}/", order.component);
        let mut items = recording.items_of(move |topic| topic.starts_with(&own));
        items.by_ref().try_for_each(|item| item.map(drop)).map_err(unreadable)?;
        let last = items.end().last_common_window;
        if last == 0 {
            let text = format!("{} has no whole window of {}", path.display(), order.component);
            return Err(ReplayError::Input(text));
        }
        Ok(Self { path, window, last })
    }

    /// Checks that the plan has the recorded windows, and ends it with the last of them.
    fn fit(&self, prepared: &mut Prepared) -> Result<(), String> {
        let window = prepared.plan.clock.window();
        if window != self.window {
            return Err(format!(
                "the recording has windows of {} s, this run of {} s: the recorded messages do not fit it",
                short(self.window),
                short(window)
            ));
        }
        prepared.plan.end_at(self.last);
        Ok(())
    }
}

/// Descriptions of all components, which end with this.
fn dismissed(prepared: Prepared) -> Vec<Description> {
    let descriptions = prepared.descriptions.clone();
    prepared.dismiss();
    descriptions
}
