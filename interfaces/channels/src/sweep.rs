//! The places that a run uses outside its output folder, and their removal.
//!
//! A run keeps iceoryx2's bookkeeping in a folder of its own and names its shared memory with a
//! prefix of its own. The orchestrator holds a lock in that folder as long as it lives; a folder
//! whose lock is free belongs to a run that was killed.
//!
//! Containers may share memory and have folders of their own. So the orchestrator holds a second
//! lock, beside the memory: who does not see the folder leaves memory alone whose lock is held.

use crate::memory::SHARED_MEMORY;
use rustix::fs::{FallocateFlags, FlockOperation, fallocate, flock};
use rustix::io::Errno;
use std::fs::{self, DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

/// Room that the bookkeeping of a run takes, and some more [bytes].
const BOOKKEEPING: u64 = 512 << 10;
/// Prefix of the names of all shared memory of Tremie.
const PREFIX: &str = "tremie_";
/// The rest of the name of the empty file beside a run's memory that is locked while the run lives.
const CLAIM: &str = "claim";

/// Folder and shared memory of one run; both are removed when this is dropped.
#[derive(Debug)]
pub struct RunPlaces {
    folder: PathBuf,
    prefix: String,
    /// Held for the life of the run; its release tells others that the run is over.
    _lock: File,
    /// The same for those who see the memory and not the folder. `None` where nothing can be
    /// written beside the memory: then no memory of the run is there.
    _claim: Option<File>,
}

impl RunPlaces {
    /// Makes the folder of run `run`, open to its user only.
    ///
    /// # Errors
    /// If it cannot be made, or belongs to another user.
    pub fn create(run: u64) -> io::Result<Self> {
        let base = base()?;
        let folder = base.join(format!("{run:016x}"));
        // Locked before it bears the name by which others find it: they never see it unlocked.
        let hidden = base.join(format!(".{run:016x}"));
        private_folder(&hidden)?;
        // Before iceoryx2 makes its files: it would fail on a full disk without saying so.
        try_room(&hidden.join("room"))?;
        let lock = File::create(hidden.join("lock"))?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)?;
        // From here on other runs see the folder.
        fs::rename(&hidden, &folder)?;
        let prefix = prefix_of(run);
        // The run reports a lack of memory itself, with a remedy.
        let _claim = claim(&prefix).ok();
        Ok(Self { folder, prefix, _lock: lock, _claim })
    }

    /// Folder of the run, which only its user can open: iceoryx2's bookkeeping, and what else belongs to
    /// the run alone.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The same as text, for iceoryx2.
    pub fn root(&self) -> String {
        self.folder.to_string_lossy().into_owned()
    }

    /// Prefix of the names of the run's shared memory.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }
}

impl Drop for RunPlaces {
    fn drop(&mut self) {
        // Nothing sensible can be done about a failure here; the next run sweeps again.
        let _ = remove(&self.folder, &self.prefix);
    }
}

/// Removes folders and shared memory that killed runs of this user left behind; returns the number
/// of such runs.
///
/// # Errors
/// If the folder that holds all runs cannot be read.
pub fn sweep_dead_runs() -> io::Result<usize> {
    let mut swept = 0;
    for (run, folder) in all_runs()? {
        if is_dead(&folder) {
            remove(&folder, &prefix_of(run))?;
            swept += 1;
        }
    }
    sweep_orphans()?;
    Ok(swept)
}

/// Runs of this user that are in progress, each with its folder, in the order of their numbers.
///
/// # Errors
/// If the folder that holds all runs cannot be read.
pub fn living_runs() -> io::Result<Vec<(u64, PathBuf)>> {
    let mut living = all_runs()?;
    living.retain(|(_, folder)| !is_dead(folder));
    living.sort_unstable();
    Ok(living)
}

/// Runs of this user that have a folder, dead or in progress.
fn all_runs() -> io::Result<Vec<(u64, PathBuf)>> {
    let mut runs = Vec::new();
    for entry in fs::read_dir(base()?)? {
        let folder = entry?.path();
        let name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        // A name with a dot is a folder that is not locked yet: it is no number, and is passed
        // over.
        if let Ok(run) = u64::from_str_radix(&name, 16) {
            runs.push((run, folder));
        }
    }
    Ok(runs)
}

/// Number of entries in shared memory that belong to run `run`.
pub fn shared_memory_of(run: u64) -> usize {
    let prefix = prefix_of(run);
    fs::read_dir(SHARED_MEMORY).map_or(0, |entries| {
        entries.flatten().filter(|e| e.file_name().to_string_lossy().starts_with(&prefix)).count()
    })
}

/// Removes shared memory of runs that have no folder: made by components that died after their
/// run's folder was swept. A run makes its folder before anything else, and removes it last.
/// Memory of a run that lives stays: its folder may be where this process cannot see it.
fn sweep_orphans() -> io::Result<()> {
    let (base, user) = (base()?, rustix::process::getuid().as_raw());
    for entry in fs::read_dir(SHARED_MEMORY)?.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let run = name.strip_prefix(PREFIX).and_then(|rest| rest.split('_').next());
        let Some(run) = run.filter(|run| run.len() == 16) else { continue };
        let mine = entry.metadata().is_ok_and(|metadata| metadata.uid() == user);
        let claim = Path::new(SHARED_MEMORY).join(format!("{PREFIX}{run}_{CLAIM}"));
        if mine && !base.join(run).exists() && (!claim.exists() || is_free(&claim)) {
            forgive_missing(fs::remove_file(entry.path()))?;
        }
    }
    Ok(())
}

/// Somebody else may have removed the same thing: that is as good.
fn forgive_missing(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

/// Prefix of the names of a run's shared memory.
pub fn prefix_of(run: u64) -> String {
    format!("{PREFIX}{run:016x}_")
}

/// Sets room aside for the bookkeeping of a run, and gives it back: iceoryx2 does not say when it
/// lacks room.
fn try_room(path: &Path) -> io::Result<()> {
    let tried = fallocate(&File::create(path)?, FallocateFlags::empty(), 0, BOOKKEEPING);
    forgive_missing(fs::remove_file(path))?;
    match tried {
        Err(error @ (Errno::NOSPC | Errno::DQUOT)) => Err(error.into()),
        // Some file systems cannot set room aside.
        Ok(()) | Err(_) => Ok(()),
    }
}

/// The folder that holds the folders of all runs of this user.
fn base() -> io::Result<PathBuf> {
    let user = rustix::process::getuid().as_raw();
    // Not the user's own choice of a temporary folder: names of sockets must stay under 108 bytes.
    let base = PathBuf::from(format!("/tmp/tremie-{user}"));
    private_folder(&base)?;
    if fs::symlink_metadata(&base)?.uid() != user {
        return Err(io::Error::new(
            io::ErrorKind::PermissionDenied,
            format!("{} belongs to another user; remove it", base.display()),
        ));
    }
    Ok(base)
}

fn private_folder(path: &Path) -> io::Result<()> {
    // Mode 0700: other users can neither read nor link into it.
    match DirBuilder::new().mode(0o700).create(path) {
        Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        other => other,
    }
}

/// Makes the file that says, while it is locked, that the memory named with `prefix` is in use.
fn claim(prefix: &str) -> io::Result<File> {
    let path = Path::new(SHARED_MEMORY).join(format!("{prefix}{CLAIM}"));
    // Locked before it bears its name, as the folder. Sweeps pass over a name with a dot.
    let hidden = Path::new(SHARED_MEMORY).join(format!(".{prefix}{CLAIM}"));
    let file = File::create(&hidden)?;
    let named = flock(&file, FlockOperation::NonBlockingLockExclusive)
        .map_err(io::Error::from)
        .and_then(|()| fs::rename(&hidden, path));
    if named.is_err() {
        forgive_missing(fs::remove_file(&hidden))?;
    }
    named.map(|()| file)
}

fn is_dead(folder: &Path) -> bool {
    is_free(&folder.join("lock"))
}

/// True if a file is there and nobody holds its lock.
fn is_free(lock: &Path) -> bool {
    match File::open(lock) {
        // The lock is let go when `lock` is dropped here. A living run holds it for good.
        // Any refusal means that it may live, also that of a file system without locks.
        Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok(),
        // Gone meanwhile, or not ours to judge.
        Err(_) => false,
    }
}

fn remove(folder: &Path, prefix: &str) -> io::Result<()> {
    // Memory first, folder last: a sweep that is cut short finds the folder and goes on.
    for entry in fs::read_dir(SHARED_MEMORY)?.flatten() {
        if entry.file_name().to_string_lossy().starts_with(prefix) {
            forgive_missing(fs::remove_file(entry.path()))?;
        }
    }
    forgive_missing(fs::remove_dir_all(folder))
}
