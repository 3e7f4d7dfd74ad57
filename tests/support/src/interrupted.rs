//! Runs of an observer that are killed and go on from a checkpoint.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tremie_sdk::messages::start::{Resume, checkpoint};
use tremie_sdk::state::{SavedState, StateArchive, StateError, StateHeader};
use tremie_sdk::{Observer, Setup};

/// A run of an observer, which may be killed.
pub struct InterruptedRun<'a, O> {
    /// Folder in which the runs have theirs.
    pub home: &'a Path,
    /// Setup of a run with its outputs in a folder.
    pub setup: &'a dyn Fn(&Path) -> Setup,
    /// Shows an observer all frames of a window.
    pub feed: &'a dyn Fn(&mut O, u64),
    /// Last window.
    pub last: u64,
}

impl<O: Observer> InterruptedRun<'_, O> {
    fn begin(&self, folder: &Path) -> O {
        std::fs::create_dir_all(folder).expect("a folder");
        O::open(&(self.setup)(folder)).expect("an observer")
    }

    /// Files and note of a run without checkpoints.
    ///
    /// # Panics
    /// If the observer fails.
    pub fn whole(&self) -> (Files, String) {
        let folder = self.home.join("whole");
        let mut observer = self.begin(&folder);
        (0..=self.last).for_each(|window| (self.feed)(&mut observer, window));
        let note = observer.close(self.last).expect("an end");
        (files(&folder), note)
    }

    /// The folder of a run that made a checkpoint at the end of a window and was killed after a later
    /// one. With the checkpoint it had gone on to the end, and ended as any.
    ///
    /// # Panics
    /// If the observer fails, or the checkpoint made a difference.
    pub fn killed(&self, kept: u64, killed: u64) -> PathBuf {
        let name = |end: &str| self.home.join(format!("{kept}-{killed}-{end}"));
        let (folder, left) = (name("kept"), name("killed"));
        let mut observer = self.begin(&folder);
        (0..=kept).for_each(|window| (self.feed)(&mut observer, window));
        keep(&mut observer, &folder, kept);
        (kept + 1..=killed).for_each(|window| (self.feed)(&mut observer, window));
        // A killed process leaves what the disk had, and ends nothing.
        copy(&folder, &left);
        (killed + 1..=self.last).for_each(|window| (self.feed)(&mut observer, window));
        let note = observer.close(self.last).expect("an end");
        assert!((files(&folder), note) == self.whole(), "window {kept} was kept and shows");
        left
    }

    /// The observer goes on in a folder from the checkpoint of a window.
    ///
    /// # Errors
    /// An observer that cannot be opened, or a state that does not fit.
    ///
    /// # Panics
    /// Without an assignment.
    pub fn resume(&self, folder: &Path, kept: u64) -> Result<O, StateError> {
        let mut setup = (self.setup)(folder);
        let at = checkpoint::folder(folder, kept);
        let assignment = setup.assignment.as_mut().expect("an assignment");
        let name = at.to_string_lossy().into_owned();
        assignment.resume =
            Some(Resume { window: kept, folder: name, same_outputs: true, bodies_only: false });
        let opened = O::open(&setup).map_err(|error| StateError::Unfit(error.to_string()));
        let mut observer = opened?;
        put_back(&mut observer, folder, kept)?;
        Ok(observer)
    }

    /// Kills the run twice after it made a checkpoint, and goes on from that to the end.
    ///
    /// # Panics
    /// If a file differs from that of a run that was never interrupted.
    pub fn assert_goes_on(&self, kept: u64, killed: [u64; 2]) {
        let first = self.killed(kept, killed[0]);
        let mut observer = self.resume(&first, kept).expect("a state that fits");
        (kept + 1..=killed[1]).for_each(|window| (self.feed)(&mut observer, window));
        let second = first.with_extension("again");
        copy(&first, &second);
        drop(observer);
        let mut observer = self.resume(&second, kept).expect("a state that fits");
        (kept + 1..=self.last).for_each(|window| (self.feed)(&mut observer, window));
        let note = observer.close(self.last).expect("an end");
        let (whole, whole_note) = self.whole();
        let found = files(&second);
        assert!(whole.keys().eq(found.keys()), "{:?} {:?}", whole.keys(), found.keys());
        for (name, bytes) in &whole {
            assert!(*bytes == found[name], "{name} differs, from {kept} on, killed at {killed:?}");
        }
        assert_eq!(note, whole_note);
    }
}

/// Contents of files by their names.
pub type Files = BTreeMap<String, Vec<u8>>;

/// All files in a folder and those within, but for checkpoints.
///
/// # Panics
/// If they cannot be read.
pub fn files(folder: &Path) -> Files {
    let mut all = Files::new();
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name == checkpoint::CHECKPOINTS {
            continue;
        }
        if path.is_dir() {
            let within = files(&path).into_iter();
            all.extend(within.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else {
            all.insert(name, std::fs::read(&path).expect("a file"));
        }
    }
    all
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy(&path, &target);
        } else {
            std::fs::copy(&path, &target).expect("a copy");
        }
    }
}

fn keep<O: Observer>(observer: &mut O, output: &Path, window: u64) {
    let folder = checkpoint::folder(output, window);
    std::fs::create_dir_all(&folder).expect("a folder");
    let header = StateHeader::whole("observer", &program::<O>(), STATE_VERSION, window);
    let told = SavedState::told_for(None, |state| observer.exchange_state(state));
    let (state, reliances) = told.expect("a state");
    reliances.settle().expect("files on the disk");
    state.write(&checkpoint::state_file(&folder, "observer"), &header).expect("a file");
}

fn put_back<O: Observer>(observer: &mut O, output: &Path, window: u64) -> Result<(), StateError> {
    let path = checkpoint::state_file(&checkpoint::folder(output, window), "observer");
    let mut archive = StateArchive::open(&path)?;
    archive.put_back(&program::<O>(), STATE_VERSION, |state| observer.exchange_state(state))
}

const STATE_VERSION: u32 = 1;

fn program<O: Observer>() -> String {
    O::PROGRAM.split_whitespace().next().unwrap_or_default().into()
}
