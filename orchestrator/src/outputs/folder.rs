//! The folder of a run's outputs: one run's alone, from before its first file to its summary.
//!
//! A run claims its folder with a lock on the file that becomes `summary.json`. The system gives
//! the lock up when the process ends, however it ends. So of two runs that begin at once one gets
//! the folder, and a killed run holds up nobody. Room for the summary is set aside in that file
//! before the first window: the end of a run is recorded even where the disk is full.

use super::{FIELDS, LOG, MANIFEST, RECORDING, SCENE, SIGNALS, SLURM, SUMMARY, Summary, TRACE};
use crate::manifest::ORCHESTRATOR;
use rustix::fs::{FallocateFlags, FlockOperation, fallocate, flock};
use rustix::io::Errno;
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use tremie_messages::scene::INPUTS;
use tremie_messages::start::{Fault, FaultKind};

/// Name of the summary while the run is under way.
const CLAIM: &str = "summary.json.part";
/// Room for the summary without its signals [bytes].
const ROOM: u64 = 256 << 10;
/// Room for each signal in the summary [bytes].
const ROOM_OF_SIGNAL: u64 = 1 << 10;

/// An output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder that the user chose holds something.
    #[error("{} holds something already; choose another --out, or remove it", .0.display())]
    Occupied(PathBuf),
    /// Another run writes into the folder that the user chose.
    #[error("{} belongs to a run that is under way; choose another --out", .0.display())]
    Claimed(PathBuf),
    /// The folder is no UTF-8 text, in which components receive it.
    #[error(
        "the folder of outputs, {0:?}, is no UTF-8 text, which components must be told; choose another --out"
    )]
    NoText(PathBuf),
    /// A file that the manifest names cannot be copied.
    #[error("cannot read {}: {error}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
    /// A file that the manifest names is not what it was.
    #[error(
        "{} has changed since the run began, which has it as {}: put the old file back, or begin a new run",
        path.display(),
        copy.display()
    )]
    Changed {
        /// The file.
        path: PathBuf,
        /// Its copy, as it was.
        copy: PathBuf,
    },
    /// The operating system refuses.
    #[error("cannot write {}: {error}", path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
}

impl OutputError {
    /// For `map_err` at `path`.
    pub fn at(path: &Path) -> impl Fn(io::Error) -> Self {
        let path = path.to_path_buf();
        move |error| Self::Io { path: path.clone(), error }
    }

    /// The fault that ends a run at `window`.
    pub fn into_fault(self, window: u64) -> Fault {
        Fault {
            kind: FaultKind::Output,
            noticed_by: ORCHESTRATOR.into(),
            blamed: ORCHESTRATOR.into(),
            window,
            message: self.to_string(),
        }
    }
}

/// A folder that belongs to one run. Where no summary is written it is left as it was found.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    /// Locked as long as this lives; becomes the summary.
    claim: File,
    /// The summary is written.
    is_finished: bool,
}

impl RunFolder {
    /// Claims the folder of a run: `out` if the user chose one, else `runs/NAME-001` and so on,
    /// where NAME is the manifest's folder or file.
    ///
    /// # Errors
    /// If the chosen folder holds something already or is another run's, or none can be made.
    pub fn choose(out: Option<&Path>, manifest: &Path) -> Result<Self, OutputError> {
        if let Some(folder) = out {
            return Self::claim(folder);
        }
        let runs = Path::new("runs");
        // Refused before a folder is made whose path components could not be given.
        let _ = text_of(runs)?;
        std::fs::create_dir_all(runs).map_err(OutputError::at(runs))?;
        let name = scenario_name(manifest);
        for number in 1.. {
            let folder = runs.join(format!("{name}-{number:03}"));
            // `create_dir` fails where the folder exists, so of two runs only one gets the number.
            match std::fs::create_dir(&folder) {
                Ok(()) => match Self::claim(&folder) {
                    // Another run was given this very folder by its user.
                    Err(OutputError::Claimed(_) | OutputError::Occupied(_)) => {}
                    claimed => return claimed,
                },
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(OutputError::at(&folder)(error)),
            }
        }
        Err(OutputError::Occupied(runs.to_path_buf()))
    }

    /// Claims `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// If it holds something or is another run's, or cannot be made.
    pub fn claim(folder: &Path) -> Result<Self, OutputError> {
        Self::claim_beside(folder, None)
    }

    /// Claims the folder of a run that was given to Slurm, in the job: what belongs to Slurm lies there.
    ///
    /// # Errors
    /// As [`RunFolder::claim`].
    pub fn claim_in_job(folder: &Path) -> Result<Self, OutputError> {
        Self::claim_beside(folder, Some(SLURM))
    }

    /// Claims `folder`, which may hold a file or folder of the name `known`.
    fn claim_beside(folder: &Path, known: Option<&str>) -> Result<Self, OutputError> {
        let path = text_of(folder)?;
        let name = path.join(CLAIM);
        loop {
            std::fs::create_dir_all(&path).map_err(OutputError::at(&path))?;
            // A folder must be empty but for a claim. It is looked at before the file is made, so
            // that nothing is left in a folder that belongs to somebody, and again under the lock.
            let has_claim = name.symlink_metadata().is_ok();
            if !has_claim && holds_more(&path, known)? {
                return Err(OutputError::Occupied(path));
            }
            let claim = match OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&name)
            {
                Ok(claim) => claim,
                // Its last user has just removed the folder.
                Err(error) if error.kind() == io::ErrorKind::NotFound => continue,
                Err(error) => return Err(OutputError::at(&name)(error)),
            };
            // On a file system without locks the files, which are made new, keep two runs apart.
            let locked = flock(&claim, FlockOperation::NonBlockingLockExclusive);
            if locked == Err(Errno::WOULDBLOCK) {
                return Err(OutputError::Claimed(path));
            }
            if !is_at(&claim, &name) {
                // The run that had it came to its end between the two calls.
                continue;
            }
            if holds_more(&path, known)? {
                if !has_claim {
                    let _ = std::fs::remove_file(&name);
                }
                return Err(OutputError::Occupied(path));
            }
            return Ok(Self { path, claim, is_finished: false });
        }
    }

    /// Claims the folder of a run that has ended, or was killed, to go on with it.
    ///
    /// # Errors
    /// If the run is still under way, or the folder cannot be written.
    pub fn reclaim(folder: &Path) -> Result<Self, OutputError> {
        let path = text_of(folder)?;
        let part = path.join(CLAIM);
        loop {
            let mut open = OpenOptions::new();
            let open = open.read(true).write(true).create(true).truncate(false);
            let claim = open.open(&part).map_err(OutputError::at(&part))?;
            if flock(&claim, FlockOperation::NonBlockingLockExclusive) == Err(Errno::WOULDBLOCK) {
                return Err(OutputError::Claimed(path));
            }
            if !is_at(&claim, &part) {
                // The run that had it came to its end between the two calls.
                continue;
            }
            return Ok(Self { path, claim, is_finished: false });
        }
    }

    /// Removes the summary of an end that is none, because the run goes on.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn forget_end(&self) -> Result<(), OutputError> {
        let path = self.file(SUMMARY);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(OutputError::at(&path)(error))
            }
            _ => Ok(()),
        }
    }

    /// Absolute path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Path of a file of the run.
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Sets room for the summary of so many signals aside.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn reserve(&self, signals: usize) -> Result<(), OutputError> {
        let room = ROOM + ROOM_OF_SIGNAL * signals as u64;
        match fallocate(&self.claim, FallocateFlags::KEEP_SIZE, 0, room) {
            Err(error @ (Errno::NOSPC | Errno::DQUOT | Errno::IO)) => {
                Err(OutputError::at(&self.file(SUMMARY))(error.into()))
            }
            // Where the file system cannot, the summary takes its chance.
            Ok(()) | Err(_) => Ok(()),
        }
    }

    /// Writes the summary, under its name only when it is whole, and gives the folder up.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn finish(&mut self, summary: &Summary) -> Result<(), OutputError> {
        let path = self.file(SUMMARY);
        let text = serde_json::to_string_pretty(summary).map_err(io::Error::from);
        let write = |text: String| {
            // Written over the room that was set aside, then cut to length and renamed: a reader
            // finds a whole summary or none.
            self.claim.seek(SeekFrom::Start(0))?;
            self.claim.write_all(text.as_bytes())?;
            self.claim.write_all(b"\n")?;
            self.claim.set_len(text.len() as u64 + 1)?;
            std::fs::rename(self.path.join(CLAIM), &path)
        };
        text.and_then(write).map_err(OutputError::at(&path))?;
        self.is_finished = true;
        Ok(())
    }

    /// Removes the files of a run that never began; nothing else that may lie there.
    pub fn clear(&self) {
        for name in [MANIFEST, SCENE, SIGNALS, LOG, RECORDING, TRACE] {
            let _ = std::fs::remove_file(self.file(name));
        }
        for folder in [FIELDS, INPUTS] {
            let _ = std::fs::remove_dir_all(self.file(folder));
        }
    }
}

impl Drop for RunFolder {
    fn drop(&mut self) {
        if self.is_finished {
            return;
        }
        // Removed while it is locked: no other run can have taken it.
        let _ = std::fs::remove_file(self.path.join(CLAIM));
        // Fails, as it shall, unless the folder is empty.
        let _ = std::fs::remove_dir(&self.path);
    }
}

/// The absolute path, if it is UTF-8 text.
fn text_of(folder: &Path) -> Result<PathBuf, OutputError> {
    let path = std::path::absolute(folder).map_err(OutputError::at(folder))?;
    if path.to_str().is_none() { Err(OutputError::NoText(path)) } else { Ok(path) }
}

/// True if there is more in the folder than a claim, and what may have the name `known`.
fn holds_more(folder: &Path, known: Option<&str>) -> Result<bool, OutputError> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(OutputError::at(folder)(error)),
    };
    for entry in entries {
        let name = entry.map_err(OutputError::at(folder))?.file_name();
        if name != CLAIM && known.is_none_or(|known| name != known) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// True if an open file still has its name.
fn is_at(file: &File, name: &Path) -> bool {
    // Device and inode: another run may have removed the file and made one of the same name.
    let same =
        |a: std::fs::Metadata, b: std::fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    match (file.metadata(), std::fs::symlink_metadata(name)) {
        (Ok(open), Ok(named)) => same(open, named),
        _ => false,
    }
}

/// `settling-sphere` of `examples/settling-sphere/manifest.toml`, `short` of `.../short.toml`.
fn scenario_name(manifest: &Path) -> String {
    let manifest = std::path::absolute(manifest).unwrap_or_else(|_| manifest.to_path_buf());
    let named = match manifest.file_name().and_then(|name| name.to_str()) {
        Some("manifest.toml") => manifest.parent().and_then(Path::file_name),
        _ if manifest.is_dir() => manifest.file_name(),
        _ => manifest.file_stem(),
    };
    named.map_or_else(|| "run".into(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn a_run_is_called_by_its_scenario() {
        assert_eq!(scenario_name(Path::new("examples/settling-sphere")), "settling-sphere");
        assert_eq!(scenario_name(Path::new("examples/bed/manifest.toml")), "bed");
        assert_eq!(scenario_name(Path::new("examples/bed/short.toml")), "short");
    }

    #[test]
    fn a_folder_that_holds_something_is_refused_and_left_as_it_is() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("new/out");
        drop(RunFolder::claim(&out).unwrap());
        assert!(!out.exists(), "a run that never began leaves nothing");
        for name in ["a", "signals.csv", ".hidden"] {
            let out = home.path().join(name);
            std::fs::create_dir(&out).unwrap();
            std::fs::write(out.join(name), "b").unwrap();
            assert!(matches!(RunFolder::claim(&out), Err(OutputError::Occupied(_))), "{name}");
            assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
        }
        let file = home.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(matches!(RunFolder::claim(&file), Err(OutputError::Io { .. })));
    }

    #[test]
    fn a_folder_that_waits_for_its_job_is_that_of_the_job() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        std::fs::create_dir_all(out.join(SLURM)).unwrap();
        assert!(matches!(RunFolder::claim(&out), Err(OutputError::Occupied(_))));
        let claimed = RunFolder::claim_in_job(&out).unwrap();
        assert!(matches!(RunFolder::claim_in_job(&out), Err(OutputError::Claimed(_))));
        drop(claimed);
        assert!(out.join(SLURM).is_dir(), "what the job said stays");
        std::fs::write(out.join(SIGNALS), "window").unwrap();
        assert!(matches!(RunFolder::claim_in_job(&out), Err(OutputError::Occupied(_))));
    }

    #[test]
    fn of_many_that_want_a_folder_at_once_one_gets_it() {
        let home = tempfile::tempdir().unwrap();
        for round in 0..50 {
            let out = home.path().join(format!("out-{round}"));
            let start = Barrier::new(6);
            let claim = || {
                start.wait();
                let claimed = RunFolder::claim(&out);
                start.wait();
                claimed
            };
            let claimed: Vec<_> = std::thread::scope(|scope| {
                let all: Vec<_> = (0..6).map(|_| scope.spawn(claim)).collect();
                all.into_iter().map(|one| one.join().unwrap()).collect()
            });
            let won = claimed.iter().filter(|one| one.is_ok()).count();
            assert_eq!(won, 1, "{claimed:?}");
            assert!(
                claimed
                    .iter()
                    .flat_map(|one| one.as_ref().err())
                    .all(|e| !matches!(e, OutputError::Io { .. }))
            );
        }
    }

    #[test]
    fn a_claim_ends_with_its_run_and_with_the_process_that_was_killed() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        let first = RunFolder::claim(&out).unwrap();
        first.reserve(10).unwrap();
        // By another way to the same folder too.
        let other = home.path().join("link");
        std::os::unix::fs::symlink(&out, &other).unwrap();
        assert!(matches!(RunFolder::claim(&other), Err(OutputError::Claimed(_))));
        // As a killed process does: the file stays, the lock goes.
        let RunFolder { claim, .. } = &first;
        flock(claim, FlockOperation::Unlock).unwrap();
        std::mem::forget(first);
        let second = RunFolder::claim(&out).unwrap();
        std::fs::write(second.file(SIGNALS), "window").unwrap();
        assert!(matches!(RunFolder::claim(&out), Err(OutputError::Claimed(_))));
        drop(second);
        assert!(matches!(RunFolder::claim(&out), Err(OutputError::Occupied(_))));
    }
}
