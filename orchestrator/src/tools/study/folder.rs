//! The folder of a study: its runs, its tables, and the lock that keeps a second study out.

use super::StudyError;
use super::runs::StudyRun;
use crate::outputs::{OutputError, RunFolder, SUMMARY, WholeCheckpoint};
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use tremie_state::write_whole;

/// File that a study locks while it is under way.
const LOCK: &str = "study.lock";
/// Folder of a run that is being copied.
const COPY: &str = "copy.part";
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
            _ => {
                remove_folder(&self.path.join(COPY))?;
                Ok(StudyLock { _file: file })
            }
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
        remove_folder(&self.of_run(run))
    }

    /// Puts a copy of a run that is done, in the folder `from`, in the place of this one; false if somebody else
    /// has taken the place meanwhile. There is never half a copy, and what was there stays until the copy is
    /// whole. An interrupt ends the copy.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn copy_run(
        &self,
        run: &StudyRun,
        from: &Path,
        interrupts: &AtomicUsize,
    ) -> Result<bool, StudyError> {
        // Beside the runs: what a kill leaves there is no run.
        let (part, to) = (self.path.join(COPY), self.of_run(run));
        let copy = || {
            remove_folder(&part)?;
            copy_folder(from, &part, interrupts)?;
            match self.use_of(run)? {
                FolderUse::Free => {}
                FolderUse::Unfinished | FolderUse::BrokenOff => remove_folder(&to)?,
                FolderUse::Done | FolderUse::UnderWay => return Ok(false),
            }
            // Refuses a folder that holds something.
            std::fs::rename(&part, &to).map(|()| true).map_err(StudyError::io(&to))
        };
        let copied = copy();
        if !matches!(copied, Ok(true)) {
            let _ = remove_folder(&part);
        }
        copied
    }

    /// Writes a file of the study anew: a reader finds the old text or the new one, whole.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), StudyError> {
        let path = self.path.join(name);
        write_whole(&path, |file| file.write_all(bytes)).map_err(StudyError::io(&path))
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

/// Removes a folder, if it is there.
fn remove_folder(folder: &Path) -> Result<(), StudyError> {
    match std::fs::remove_dir_all(folder) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StudyError::io(folder)(error)),
        _ => Ok(()),
    }
}

/// Copies a folder, to be on the disk also after a power cut.
fn copy_folder(from: &Path, to: &Path, interrupts: &AtomicUsize) -> Result<(), StudyError> {
    std::fs::create_dir(to).map_err(StudyError::io(to))?;
    for entry in std::fs::read_dir(from).map_err(StudyError::io(from))? {
        if interrupts.load(Ordering::Relaxed) > 0 {
            return Err(StudyError::Interrupted);
        }
        let entry = entry.map_err(StudyError::io(from))?;
        let (from, to) = (entry.path(), to.join(entry.file_name()));
        if from.is_dir() {
            copy_folder(&from, &to, interrupts)?;
        } else {
            std::fs::copy(&from, &to).map_err(StudyError::io(&from))?;
            sync(&to)?;
        }
    }
    sync(to)
}

fn sync(path: &Path) -> Result<(), StudyError> {
    File::open(path).and_then(|file| file.sync_all()).map_err(StudyError::io(path))
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

    fn texts(folder: &Path) -> Vec<(PathBuf, String)> {
        let mut all = Vec::new();
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => all.extend(texts(&path)),
                false => all.push((path.clone(), std::fs::read_to_string(path).unwrap())),
            }
        }
        all.sort();
        all
    }

    /// A copy has all that the run has. One that cannot be made leaves what was there.
    #[test]
    fn a_run_is_copied_whole_or_not_at_all() {
        let home = tempfile::tempdir().unwrap();
        let [from, to] = ["from", "to"].map(|name| StudyFolder { path: home.path().join(name) });
        let run = StudyRun { name: "a1".into(), ..StudyRun::default() };
        let [from_run, to_run] = [&from, &to].map(|folder| folder.of_run(&run));
        for (folder, text) in [(&from_run, "new"), (&to_run, "old")] {
            std::fs::create_dir_all(folder.join("checkpoints/000012")).unwrap();
            std::fs::write(folder.join("checkpoints/000012/fluid.zip"), text).unwrap();
        }
        std::fs::write(from_run.join("summary.json"), "{}").unwrap();
        std::fs::write(to_run.join("begun.toml"), "old").unwrap();
        let old = texts(&to_run);
        // What a kill left of an earlier copy.
        std::fs::create_dir(to.path().join(COPY)).unwrap();
        let copy = |from: &Path, interrupts| to.copy_run(&run, from, &AtomicUsize::new(interrupts));
        assert!(copy(&home.path().join("nowhere"), 0).is_err());
        assert!(matches!(copy(&from_run, 1), Err(StudyError::Interrupted)));
        assert_eq!(texts(to.path()), old);
        let other = RunFolder::reclaim(&to_run).unwrap();
        assert!(!copy(&from_run, 0).unwrap(), "somebody else has it");
        drop(other);
        assert_eq!(texts(to.path()), old);
        assert!(copy(&from_run, 0).unwrap());
        let within = |folder: &Path| -> Vec<_> {
            let all = texts(folder).into_iter();
            all.map(|(path, text)| (path.strip_prefix(folder).unwrap().to_owned(), text)).collect()
        };
        assert_eq!(within(&to_run), within(&from_run));
        assert_eq!(within(&from_run).len(), 2);
        std::fs::create_dir(to.path().join(COPY)).unwrap();
        drop(to.lock().unwrap());
        assert!(!to.path().join(COPY).exists());
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
}
