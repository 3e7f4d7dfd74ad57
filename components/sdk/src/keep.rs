//! Keeping the states of a component for checkpoints, and putting one back.
//!
//! A component stands still only while its state is copied in memory. A thread then waits until the disk has the
//! files that the state goes on from, writes the copy, and tells the orchestrator when the disk has that, too.

use crate::line::Replier;
use crate::roles::no_state;
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Instant;
use tremie_messages::start::{Description, Hello, Reply, Resume, checkpoint};
use tremie_state::{SavedState, StateArchive, StateError, StateExchange, StateHeader, StatePlace};

/// Keeps the states of one component.
pub struct StateKeeper {
    component: String,
    /// Name of the program, without its version.
    program: String,
    /// Folder of the run's outputs.
    output: PathBuf,
    version: Option<u32>,
    writer: Option<JoinHandle<()>>,
}

impl StateKeeper {
    /// Keeper of a component that has described itself.
    pub fn new(hello: &Hello, description: &Description) -> Self {
        Self {
            component: hello.component.clone(),
            program: program_name(&description.program).to_string(),
            output: PathBuf::from(&hello.output),
            version: description.state,
            writer: None,
        }
    }

    /// True if the component has a state.
    pub fn has_state(&self) -> bool {
        self.version.is_some()
    }

    /// Copies the state that `tell` names, and begins to write it for the checkpoint of `window`. A
    /// state that cannot be kept is told, too.
    pub fn keep(
        &mut self,
        window: u64,
        replier: Replier,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) {
        let Some(version) = self.version else { return };
        // The last one is written long since: the orchestrator asks for one at a time.
        self.wait();
        let begin = Instant::now();
        let folder = checkpoint::unfinished(&self.output, window);
        let place = StatePlace {
            path: checkpoint::state_file(&folder, &self.component),
            header: StateHeader::whole(&self.component, &self.program, version, window),
            within: String::new(),
        };
        let (state, reliances) = match SavedState::told_for(Some(&place), tell) {
            Ok(told) => told,
            Err(error) => return tell_kept(&replier, window, Err(error)),
        };
        let copied = begin.elapsed().as_nanos() as u64;
        let write = move || {
            let write = || state.write(&place.path, &place.header);
            let written = reliances.settle().and_then(|()| write());
            tell_kept(&replier, window, written.map(|bytes| (bytes, copied)));
        };
        self.writer = Some(std::thread::spawn(write));
    }

    /// Waits until the disk has the last state.
    pub fn wait(&mut self) {
        // A panic there was told by the thread's own message; the checkpoint stays unfinished.
        let _ = self.writer.take().map(JoinHandle::join);
    }

    /// Puts the state of a checkpoint back where `tell` names it.
    ///
    /// # Errors
    /// No such file, a damaged one, or another's.
    pub fn put_back(
        &self,
        resume: &Resume,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<(), StateError> {
        let path = checkpoint::state_file(Path::new(&resume.folder), &self.component);
        let Some(version) = self.version else {
            return Err(no_state(&self.program));
        };
        let mut archive = StateArchive::open(&path)?;
        if archive.header().window != resume.window {
            let found = archive.header().window;
            let text = format!("it is the state at the end of window {found}");
            return Err(StateError::Damaged { name: path.display().to_string(), why: text });
        }
        archive.put_back(&self.program, version, tell)
    }
}

impl Drop for StateKeeper {
    fn drop(&mut self) {
        self.wait();
    }
}

/// The name of a program as it describes itself, without the version after it: by this name its states are
/// told from another's.
pub fn program_name(program: &str) -> &str {
    program.split_whitespace().next().unwrap_or(program)
}

/// `kept`: length of the file, and time of the copy [ns].
fn tell_kept(replier: &Replier, window: u64, kept: Result<(u64, u64), StateError>) {
    let reply = match kept {
        Ok((bytes, copied)) => Reply::Saved { window, bytes, copied },
        Err(error) => Reply::NotSaved { window, why: error.to_string() },
    };
    // A closed line ends the component elsewhere.
    let _ = replier.reply(&reply);
}
