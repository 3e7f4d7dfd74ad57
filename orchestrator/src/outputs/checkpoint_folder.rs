//! The folders of checkpoints: begun under a name that says unfinished, and renamed when all is in them.

use super::folder::OutputError;
use crate::manifest::ORCHESTRATOR;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use tremie_messages::start::{Clock, checkpoint};
use tremie_state::{
    SavedState, StateArchive, StateError, StateExchange, StateHeader, bytes_on_disk,
};

/// What a checkpoint is of: `checkpoint.json` in its folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckpointRecord {
    /// Version of Tremie that made it.
    pub tremie: String,
    /// Version of the interface between components.
    pub interface: u32,
    /// Kind of processor and system, as `x86_64 linux`.
    pub machine: String,
    /// Window at whose end it was made.
    pub window: u64,
    /// Simulated time then [s].
    pub time: f64,
    /// Ticks of the run.
    pub clock: Clock,
    /// Folder from which the manifest's programs are found.
    pub programs: PathBuf,
    /// Signal that came near its limit, if a watchdog asked for the checkpoint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_for: Option<String>,
    /// Components with a state, by name.
    pub components: BTreeMap<String, ComponentRecord>,
}

/// A component's part of a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComponentRecord {
    /// Program and version.
    pub program: String,
    /// Version of its state.
    pub state: u32,
    /// Substeps that it makes in a window.
    pub substeps: u32,
    /// Length of its file, or of all parts [bytes].
    pub bytes: u64,
}

const RECORD: &str = "checkpoint.json";
/// Version of the orchestrator's own state.
const STATE_VERSION: u32 = 2;

/// Why there is no checkpoint to go on from.
#[derive(Debug, thiserror::Error)]
pub enum NoCheckpoint {
    /// There is none.
    #[error("{} holds no checkpoint: the run was too short for one, or could not be kept", .0.display())]
    None(PathBuf),
    /// There is none of that window.
    #[error("{} holds no checkpoint of window {window}; there are those of {}", out.display(), list(found))]
    OtherWindows {
        /// The folder of outputs.
        out: PathBuf,
        /// The window that was asked for.
        window: u64,
        /// Windows of those that are there.
        found: Vec<u64>,
    },
    /// It is damaged.
    #[error("the checkpoint {} is damaged: {why}{}", folder.display(), hint(others))]
    Damaged {
        /// Its folder.
        folder: PathBuf,
        /// What is wrong.
        why: String,
        /// Windows of those that are there besides.
        others: Vec<u64>,
    },
}

/// What to try where one checkpoint is of no use.
fn hint(others: &[u64]) -> String {
    let Some(newest) = others.last() else { return String::new() };
    format!("; try an earlier one: --at {newest}")
}

fn list(windows: &[u64]) -> String {
    windows.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
}

/// A checkpoint that is being written.
#[derive(Debug)]
pub struct UnfinishedCheckpoint {
    output: PathBuf,
    window: u64,
}

impl UnfinishedCheckpoint {
    /// Makes the folder for the checkpoint of `window`, in the outputs of a run.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn begin(output: &Path, window: u64) -> Result<Self, OutputError> {
        let folder = checkpoint::unfinished(output, window);
        remove_unfinished_checkpoints(output);
        fs::create_dir_all(&folder).map_err(OutputError::at(&folder))?;
        Ok(Self { output: output.to_path_buf(), window })
    }

    /// Its window.
    pub fn window(&self) -> u64 {
        self.window
    }

    /// Adds the orchestrator's part, and gives the folder its name. From then on the checkpoint is whole,
    /// also when the machine loses its power.
    ///
    /// # Errors
    /// If the disk refuses; the folder is removed then.
    pub fn finish(
        self,
        record: &CheckpointRecord,
        manifest: &str,
        state: &SavedState,
    ) -> Result<PathBuf, OutputError> {
        let part = checkpoint::unfinished(&self.output, self.window);
        let whole = checkpoint::folder(&self.output, self.window);
        let write = || -> Result<(), OutputError> {
            let header = StateHeader::whole(ORCHESTRATOR, ORCHESTRATOR, STATE_VERSION, self.window);
            let path = checkpoint::state_file(&part, ORCHESTRATOR);
            state
                .write(&path, &header)
                .map_err(|error| OutputError::at(&path)(io::Error::other(error.to_string())))?;
            let text = serde_json::to_string_pretty(record).map_err(io::Error::from);
            let text = text.map_err(OutputError::at(&part.join(RECORD)))?;
            for (name, text) in [(super::MANIFEST, manifest), (RECORD, text.as_str())] {
                let path = part.join(name);
                fs::write(&path, text)
                    .and_then(|()| File::open(&path)?.sync_all())
                    .map_err(OutputError::at(&path))?;
            }
            sync_folder(&part)?;
            // There is none: a run that goes on from an earlier checkpoint removes the later ones.
            fs::rename(&part, &whole).map_err(OutputError::at(&whole))?;
            sync_folder(&self.output.join(checkpoint::CHECKPOINTS))
        };
        // The folder of one that is not whole goes when `self` is dropped.
        write().map(|()| whole.clone())
    }
}

impl Drop for UnfinishedCheckpoint {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(checkpoint::unfinished(&self.output, self.window));
        remove_folder_if_empty(&self.output);
    }
}

/// Waits until the disk has the names in a folder.
fn sync_folder(folder: &Path) -> Result<(), OutputError> {
    File::open(folder).and_then(|folder| folder.sync_all()).map_err(OutputError::at(folder))
}

/// Removes folders that never became whole: their run was killed, or they were given up while components
/// were still putting files into them.
pub fn remove_unfinished_checkpoints(output: &Path) {
    let entries = fs::read_dir(output.join(checkpoint::CHECKPOINTS)).into_iter().flatten();
    for entry in entries.flatten() {
        if entry.file_name().to_str().is_some_and(checkpoint::is_unfinished) {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
    remove_folder_if_empty(output);
}

/// Removes the folder of checkpoints where there are none.
fn remove_folder_if_empty(output: &Path) {
    // Fails, as it shall, unless it is empty.
    let _ = fs::remove_dir(output.join(checkpoint::CHECKPOINTS));
}

/// Removes all checkpoints of a run but the newest `keep`, and the newest that a watchdog asked for.
pub fn remove_old_checkpoints(output: &Path, keep: usize) {
    let mut windows = windows_of(output);
    let is_asked = |window: &u64| {
        let text = fs::read_to_string(checkpoint::folder(output, *window).join(RECORD));
        let record =
            text.ok().and_then(|text| serde_json::from_str::<CheckpointRecord>(&text).ok());
        record.is_some_and(|record| record.made_for.is_some())
    };
    if let Some(asked) = windows.iter().rposition(is_asked) {
        windows.remove(asked);
    }
    for window in windows.into_iter().rev().skip(keep) {
        remove(output, window);
    }
}

/// Checkpoints of windows after the one from whose end a run goes on. Tables and recordings are cut
/// there, and no later state fits them.
///
/// They lose their names before anything is cut: a run that is killed then goes on from the earlier one.
/// Where the run is refused they get their names back.
#[derive(Debug)]
pub struct LaterCheckpoints {
    output: PathBuf,
    windows: Vec<u64>,
}

impl LaterCheckpoints {
    /// Sets those after `window` aside.
    pub fn set_aside(output: &Path, window: u64) -> Self {
        let is_moved = |later: &u64| {
            let (whole, part) = both(output, *later);
            *later > window && fs::rename(whole, part).is_ok()
        };
        let windows = windows_of(output).into_iter().filter(is_moved).collect();
        Self { output: output.to_path_buf(), windows }
    }

    /// Removes them: the run goes on.
    pub fn remove(mut self) {
        for window in std::mem::take(&mut self.windows) {
            let _ = fs::remove_dir_all(both(&self.output, window).1);
        }
    }
}

impl Drop for LaterCheckpoints {
    fn drop(&mut self) {
        for window in &self.windows {
            let (whole, part) = both(&self.output, *window);
            let _ = fs::rename(part, whole);
        }
    }
}

/// Folder of the checkpoint of a window, whole and not.
fn both(output: &Path, window: u64) -> (PathBuf, PathBuf) {
    (checkpoint::folder(output, window), checkpoint::unfinished(output, window))
}

fn remove(output: &Path, window: u64) {
    // Renamed first: a folder of that name is whole, at any time.
    let (whole, part) = both(output, window);
    let _ = fs::rename(&whole, &part);
    let _ = fs::remove_dir_all(&part);
}

/// Windows of the whole checkpoints in the outputs of a run, in order.
fn windows_of(output: &Path) -> Vec<u64> {
    let Ok(entries) = fs::read_dir(output.join(checkpoint::CHECKPOINTS)) else { return Vec::new() };
    let window =
        |entry: io::Result<fs::DirEntry>| checkpoint::window_of(entry.ok()?.file_name().to_str()?);
    let mut windows: Vec<u64> = entries.filter_map(window).collect();
    windows.sort_unstable();
    windows
}

/// A whole checkpoint.
#[derive(Clone, Debug)]
pub struct WholeCheckpoint {
    folder: PathBuf,
    /// What it is of.
    pub record: CheckpointRecord,
    /// The manifest of its run, as resolved; paths of copies are relative to the run's folder.
    pub manifest: String,
    /// Windows of earlier ones.
    others: Vec<u64>,
}

impl WholeCheckpoint {
    /// The newest checkpoint in the outputs of a run, or that of a window.
    ///
    /// # Errors
    /// See [`NoCheckpoint`].
    pub fn find(output: &Path, window: Option<u64>) -> Result<Self, NoCheckpoint> {
        let found = windows_of(output);
        let newest = *found.last().ok_or_else(|| NoCheckpoint::None(output.to_path_buf()))?;
        let window = window.unwrap_or(newest);
        if !found.contains(&window) {
            return Err(NoCheckpoint::OtherWindows { out: output.to_path_buf(), window, found });
        }
        let others = found.into_iter().filter(|other| *other < window).collect();
        Self::open(checkpoint::folder(output, window), others)
    }

    fn open(folder: PathBuf, others: Vec<u64>) -> Result<Self, NoCheckpoint> {
        let damaged = |why: String| NoCheckpoint::Damaged {
            folder: folder.clone(),
            why,
            others: others.clone(),
        };
        let read = |name: &str| {
            fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"))
        };
        let record = read(RECORD).and_then(|text| {
            serde_json::from_str::<CheckpointRecord>(&text)
                .map_err(|error| format!("{RECORD}: {error}"))
        });
        let record = record.map_err(damaged)?;
        let manifest = read(super::MANIFEST).map_err(damaged)?;
        for (name, component) in &record.components {
            let path = checkpoint::state_file(&folder, name);
            let length = bytes_on_disk(&path);
            if length != component.bytes {
                return Err(damaged(format!(
                    "{} has {length} bytes, expected {}",
                    path.display(),
                    component.bytes
                )));
            }
        }
        Ok(Self { folder, record, manifest, others })
    }

    /// What to try if this one is of no use; empty if there is no earlier one.
    pub fn hint(&self) -> String {
        hint(&self.others)
    }

    /// Its folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The manifest in the folder of its run: as its neighbour, its own manifest finds the copies of files.
    pub fn manifest_file(&self) -> PathBuf {
        let run = self.folder.parent().and_then(Path::parent).unwrap_or(Path::new(""));
        run.join(super::MANIFEST)
    }

    /// Puts the orchestrator's part back where `tell` names it.
    ///
    /// # Errors
    /// A damaged state, or another's.
    pub fn put_back(
        &self,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<(), StateError> {
        let path = checkpoint::state_file(&self.folder, ORCHESTRATOR);
        StateArchive::open(&path)?.put_back(ORCHESTRATOR, STATE_VERSION, tell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(windows: &[u64]) -> tempfile::TempDir {
        let home = tempfile::tempdir().unwrap();
        windows
            .iter()
            .for_each(|w| fs::create_dir_all(checkpoint::folder(home.path(), *w)).unwrap());
        home
    }

    #[test]
    fn later_checkpoints_come_back_where_a_run_is_refused_and_go_where_it_goes_on() {
        let home = output(&[8, 16, 24]);
        let later = LaterCheckpoints::set_aside(home.path(), 8);
        assert_eq!(windows_of(home.path()), [8]);
        drop(later);
        assert_eq!(windows_of(home.path()), [8, 16, 24]);
        LaterCheckpoints::set_aside(home.path(), 16).remove();
        assert_eq!(windows_of(home.path()), [8, 16]);
        // As where the run was killed meanwhile.
        std::mem::forget(LaterCheckpoints::set_aside(home.path(), 8));
        remove_unfinished_checkpoints(home.path());
        assert_eq!(windows_of(home.path()), [8]);
    }
}
