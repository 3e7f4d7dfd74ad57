//! The trait of an observer: a component without a role in the physics, which sees frames.

use crate::roles::no_state;
use crate::sent::CopiedMessage;
use crate::setup::Setup;
use std::error::Error;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::Path;
use tremie_messages::frame::{
    BodySample, ComponentTiming, LoadSample, LogHeader, ProfileBin, ProfileHeader, SliceHeader,
    SliceNode, SurfaceSample, TimingHeader, VolumeHeader,
};
use tremie_messages::start::{Description, RunCoupling, SentChannel, Signal};
use tremie_messages::{Problem, Stamp};
use tremie_state::{StateError, StateExchange};

/// When a frame was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Stamp of the frame.
    pub stamp: Stamp,
    /// Simulated time [s].
    pub time: f64,
}

/// Something that went wrong in an observer.
#[derive(Debug, thiserror::Error)]
pub enum ObserverError {
    /// An output could not be written, or not all of it; ends the run, which is made for its
    /// outputs.
    #[error("{0}")]
    Output(String),
    /// Anything else; a warning for the run.
    #[error("{0}")]
    Other(String),
}

impl ObserverError {
    /// `path` could not be written, with the system's own words for the reason where `error` has
    /// them.
    pub fn output(path: &Path, error: &(dyn Error + 'static)) -> Self {
        Self::Output(format!("cannot write {}: {}", path.display(), root_cause(error)))
    }
}

/// Makes the file at `path` anew for this process alone, as long as it is kept open: two runs that
/// were given the same file do not write into each other's.
///
/// # Errors
/// If it cannot be written, or somebody has it.
pub fn own_file(path: &Path) -> Result<File, ObserverError> {
    let open = OpenOptions::new().write(true).create(true).truncate(false).open(path);
    let file = open.map_err(|error| ObserverError::output(path, &error))?;
    lock(&file, path).map_err(ObserverError::Other)?;
    // Devices have no length to lose.
    if file.metadata().is_ok_and(|metadata| metadata.is_file()) {
        file.set_len(0).map_err(|error| ObserverError::output(path, &error))?;
    }
    Ok(file)
}

/// Keeps other processes from writing the file as long as it is open.
///
/// # Errors
/// A sentence, if somebody has it.
pub(crate) fn lock(file: &File, path: &Path) -> Result<(), String> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            Err(format!("{} is being written by another run; choose another file", path.display()))
        }
        _ => Ok(()),
    }
}

/// The deepest cause of an error that the system gave a name, or the error itself.
fn root_cause<'a>(error: &'a (dyn Error + 'static)) -> &'a (dyn Error + 'static) {
    let mut named = error;
    let mut at = Some(error);
    while let Some(cause) = at {
        if cause.is::<std::io::Error>() {
            named = cause;
        }
        at = cause.source();
    }
    named
}

impl From<Vec<Problem>> for ObserverError {
    fn from(problems: Vec<Problem>) -> Self {
        Self::Other(problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; "))
    }
}

impl From<StateError> for ObserverError {
    fn from(error: StateError) -> Self {
        Self::Other(error.to_string())
    }
}

/// An observer: told of frames as they come, in order within a stream.
///
/// Frames of several streams of one window come one after the other, in no order that could be
/// relied on; a lossless observer may rely on each coming, a lossy one must not. Only what
/// [`Description::watches`] asks for comes.
pub trait Observer: Sized {
    /// Name and version of the program, for the log.
    const PROGRAM: &'static str;

    /// Name and version as the program describes itself: another than `PROGRAM` only where one program
    /// serves whatever a user wrote.
    fn program() -> String {
        Self::PROGRAM.into()
    }

    /// Checks the parameters and says what the observer needs; nothing is opened yet.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Opens outputs. Called once, when the assignment is known. Where [`Setup::goes_on`] says so, outputs
    /// of the run before are there, and are left as they are: its state is put back next.
    fn open(setup: &Setup) -> Result<Self, ObserverError>;

    /// Names the state of the observer and of its outputs once for both ways: to keep it when it has
    /// seen all frames of a checkpoint's window and none of a later one, and to put it back. Then
    /// outputs are as they were, and what was written since is gone. Called only where the
    /// description has a version of the state ([`Description::state`]). An observer without one begins
    /// its outputs anew when a run goes on. Files that the state goes on from must be on the disk before it is:
    /// [`StateExchange::relies_on`] waits for them without holding up frames.
    ///
    /// # Errors
    /// A state that is damaged or another's; outputs that are no longer there.
    fn exchange_state(&mut self, _state: &mut StateExchange<'_>) -> Result<(), StateError> {
        Err(no_state(Self::PROGRAM))
    }

    /// All bodies at one moment; `from` is the sending component.
    fn bodies(
        &mut self,
        _from: &str,
        _at: Moment,
        _bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// All vertices of the scene's deformable surfaces at one moment. Comes only to observers that
    /// ask for them.
    fn surfaces(
        &mut self,
        _from: &str,
        _at: Moment,
        _samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Loads on all bodies at one moment. Comes only to observers that ask for loads.
    fn loads(
        &mut self,
        _from: &str,
        _at: Moment,
        _loads: &[LoadSample],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Wall time that the components of `coupling` have taken so far, one for each. Comes only to
    /// observers that ask for timings, and to lossless ones, too, only as far as there is room.
    fn timings(
        &mut self,
        _at: Moment,
        _coupling: &RunCoupling,
        _header: &TimingHeader,
        _timings: &[ComponentTiming],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// A cut through a field.
    fn slice(
        &mut self,
        _from: &str,
        _name: &str,
        _at: Moment,
        _header: &SliceHeader,
        _nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Nodes of a lattice. Comes only to observers that ask for volumes.
    fn volume(
        &mut self,
        _from: &str,
        _name: &str,
        _at: Moment,
        _header: &VolumeHeader,
        _nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// A table of a profile of grains, when it has ended: a bin for each of the scene's profile of
    /// that name. Comes only to observers that ask for profiles.
    fn profile(
        &mut self,
        _from: &str,
        _name: &str,
        _at: Moment,
        _header: &ProfileHeader,
        _bins: &[ProfileBin],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Signals of a component, in the order of `names`.
    fn signals(
        &mut self,
        _from: &str,
        _at: Moment,
        _names: &[Signal],
        _values: &[f64],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Hashes of the messages that a component sent on `channels`, in rows: a window, and a hash for
    /// each channel ([`FrameContent::Hashes`](tremie_messages::start::FrameContent::Hashes)). Comes
    /// only to lossless observers that ask for hashes.
    fn hashes(
        &mut self,
        _from: &str,
        _at: Moment,
        _channels: &[SentChannel],
        _rows: &[u64],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// All messages that a component sent in a window, in their order; each says which of the
    /// channels it went through. Comes only to lossless observers that ask for messages.
    fn messages(
        &mut self,
        _from: &str,
        _at: Moment,
        _channels: &[SentChannel],
        _messages: &[CopiedMessage<'_>],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// A line of the log.
    fn log(&mut self, _at: Moment, _header: &LogHeader, _text: &str) -> Result<(), ObserverError> {
        Ok(())
    }

    /// The run is over and every frame was delivered; `last_common_window` is the last one that all
    /// components completed. Returns a note for the run's summary. What the observer serves may
    /// stay up until it is dropped.
    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError>;
}
