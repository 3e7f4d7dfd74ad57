//! The folder of a study: its runs, its tables, and the lock that keeps a second study out.

use super::StudyError;
use super::runs::StudyRun;
use crate::outputs::{OutputError, RunFolder, SUMMARY, WholeCheckpoint};
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// File that a study locks while it is under way.
const LOCK: &str = "study.lock";
/// Folder of the runs.
const RUNS: &str = "runs";

/// The folder of a study.
#[derive(Debug)]
pub struct StudyFolder {
    path: PathBuf,
}

/// A lock on the folder of a study; it ends with this process, however that ends.
#[derive(Debug)]
pub struct StudyLock {
    _file: File,
}

/// End of a run as its summary tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct RunOutcome {
    /// Status, as `completed`.
    pub status: String,
    /// Wall time of its windows [s].
    pub wall_time: Option<f64>,
}

impl RunOutcome {
    /// True if the run is done and is never made again.
    pub fn is_done(&self) -> bool {
        matches!(self.status.as_str(), "completed" | "stopped")
    }
}

/// Readiness of a run's folder for the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FolderUse {
    /// Nothing is there.
    Free,
    /// A run is there that is done.
    Done,
    /// A run is there that was broken off, and can go on from a checkpoint.
    BrokenOff,
    /// A run is there that failed, or was broken off before its first checkpoint.
    Unfinished,
    /// A run is under way there.
    UnderWay,
}

impl StudyFolder {
    /// The folder at `path`, or `studies/NAME`, where NAME is that of the study file.
    pub fn of(path: Option<&Path>, file: &Path) -> Self {
        match path {
            Some(path) => Self { path: path.to_path_buf() },
            None => Self::among(None, file),
        }
    }

    /// The folder of one of several studies: NAME in the folder at `path`, or in `studies`.
    pub fn among(path: Option<&Path>, file: &Path) -> Self {
        Self { path: path.unwrap_or(Path::new("studies")).join(study_name(file)) }
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a run's folder.
    pub fn of_run(&self, run: &StudyRun) -> PathBuf {
        self.path.join(RUNS).join(&run.name)
    }

    /// Makes the folder, and locks it.
    ///
    /// # Errors
    /// If another study has it, or the disk refuses.
    pub fn lock(&self) -> Result<StudyLock, StudyError> {
        let runs = self.path.join(RUNS);
        std::fs::create_dir_all(&runs).map_err(StudyError::io(&runs))?;
        let path = self.path.join(LOCK);
        let mut open = OpenOptions::new();
        let file = open.write(true).create(true).truncate(false).open(&path);
        let file = file.map_err(StudyError::io(&path))?;
        match flock(&file, FlockOperation::NonBlockingLockExclusive) {
            Err(Errno::WOULDBLOCK) => Err(StudyError::Claimed(self.path.clone())),
            // A file system without locks has none to respect.
            _ => Ok(StudyLock { _file: file }),
        }
    }

    /// End of a run; `None` if it has not ended in order.
    pub fn outcome(&self, run: &StudyRun) -> Option<RunOutcome> {
        outcome_in(&self.of_run(run))
    }

    /// Readiness of a run's folder.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn use_of(&self, run: &StudyRun) -> Result<FolderUse, StudyError> {
        let folder = self.of_run(run);
        if self.outcome(run).is_some_and(|outcome| outcome.is_done()) {
            return Ok(FolderUse::Done);
        }
        if !folder.exists() {
            return Ok(FolderUse::Free);
        }
        match RunFolder::reclaim(&folder) {
            Ok(_) => Ok(match self.outcome(run).is_some_and(|outcome| outcome.is_done()) {
                // It came to its end between the two looks.
                true => FolderUse::Done,
                false if self.can_go_on(run) => FolderUse::BrokenOff,
                false => FolderUse::Unfinished,
            }),
            Err(OutputError::Claimed(_)) => Ok(FolderUse::UnderWay),
            Err(error) => Err(error.into()),
        }
    }

    /// True if a run that nobody has anymore can go on: it did not fail, and left a checkpoint.
    fn can_go_on(&self, run: &StudyRun) -> bool {
        let failed = self.outcome(run).is_some_and(|outcome| outcome.status == "failed");
        !failed && WholeCheckpoint::find(&self.of_run(run), None).is_ok()
    }

    /// Removes a run that failed or was broken off.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn remove(&self, run: &StudyRun) -> Result<(), StudyError> {
        let folder = self.of_run(run);
        match std::fs::remove_dir_all(&folder) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(StudyError::Io { path: folder, error })
            }
            _ => Ok(()),
        }
    }

    /// Puts a copy of a run, in the folder `from`, in the place of this one. There is never half a copy. A run
    /// without a folder leaves none.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn copy_run(&self, run: &StudyRun, from: &Path) -> Result<(), StudyError> {
        self.remove(run)?;
        if !from.exists() {
            return Ok(());
        }
        let to = self.of_run(run);
        let copy = || {
            // Beside the runs: what a kill leaves there is no run.
            let beside = tempfile::Builder::new().prefix(".copy").tempdir_in(&self.path)?;
            let whole = beside.path().join(RUNS);
            copy_folder(from, &whole)?;
            std::fs::rename(whole, &to)
        };
        copy().map_err(StudyError::io(&to))
    }

    /// Writes a file of the study anew: a reader finds the old text or the new one, whole.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let path = self.path.join(name);
        let write = || {
            let mut file = tempfile::NamedTempFile::new_in(&self.path)?;
            file.write_all(bytes)?;
            // Temporary files are their owner's alone; tables are not.
            let mode = std::os::unix::fs::PermissionsExt::from_mode(0o644);
            file.as_file().set_permissions(mode)?;
            file.as_file().sync_data()?;
            file.persist(&path).map_err(|error| error.error)
        };
        write().map(drop).map_err(StudyError::io(&path))
    }
}

/// `pistons` of `pistons.toml`; the folder's name of `study.toml`.
fn study_name(file: &Path) -> String {
    let file = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
    let named = match file.file_name().and_then(|name| name.to_str()) {
        Some("study.toml") => file.parent().and_then(Path::file_name),
        _ => file.file_stem(),
    };
    named.map_or_else(|| "study".into(), |name| name.to_string_lossy().into_owned())
}

/// Folders of the runs of a study that are done, by their names; `None` if it is no study's folder.
pub fn done_runs(folder: &Path) -> Option<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder.join(RUNS)).ok()?;
    let runs = entries.flatten().map(|entry| entry.path());
    let is_done = |run: &PathBuf| outcome_in(run).is_some_and(|outcome| outcome.is_done());
    let mut runs: Vec<_> = runs.filter(is_done).collect();
    runs.sort();
    Some(runs)
}

fn copy_folder(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir(to)?;
    for entry in std::fs::read_dir(from)? {
        let (from, to) = entry.map(|entry| (entry.path(), to.join(entry.file_name())))?;
        if from.is_dir() {
            copy_folder(&from, &to)?
        } else {
            std::fs::copy(&from, &to).map(drop)?
        }
    }
    Ok(())
}

fn outcome_in(folder: &Path) -> Option<RunOutcome> {
    let text = std::fs::read_to_string(folder.join(SUMMARY)).ok()?;
    let summary: serde_json::Value = serde_json::from_str(&text).ok()?;
    let status = summary["status"].as_str()?.to_string();
    Some(RunOutcome { status, wall_time: summary["wall_time"].as_f64() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_study_is_called_by_its_file() {
        assert_eq!(study_name(Path::new("a/pistons.toml")), "pistons");
        assert_eq!(study_name(Path::new("a/valve/study.toml")), "valve");
    }

    #[test]
    fn of_two_studies_one_gets_the_folder() {
        let home = tempfile::tempdir().unwrap();
        let folder = StudyFolder::of(Some(&home.path().join("out")), Path::new("a.toml"));
        let lock = folder.lock().unwrap();
        assert!(matches!(folder.lock(), Err(StudyError::Claimed(_))));
        drop(lock);
        folder.lock().unwrap();
    }

    #[test]
    fn a_file_is_written_whole() {
        let home = tempfile::tempdir().unwrap();
        let folder = StudyFolder::of(Some(home.path()), Path::new("a.toml"));
        folder.write("runs.csv", b"one").unwrap();
        folder.write("runs.csv", b"two").unwrap();
        assert_eq!(std::fs::read(home.path().join("runs.csv")).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(home.path()).unwrap().count(), 1);
    }
}
