//! What an observer implements: a component without a role in the physics, which sees frames.

use crate::setup::Setup;
use tremie_messages::frame::{
    BodySample, LogHeader, SliceHeader, SliceNode, SurfaceSample, VolumeHeader,
};
use tremie_messages::start::{Description, Signal};
use tremie_messages::{Problem, Stamp};

/// When a frame was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Stamp of the frame.
    pub stamp: Stamp,
    /// Simulated time [s].
    pub time: f64,
}

/// Something that went wrong in an observer; a warning for the run.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct ObserverError(pub String);

impl From<Vec<Problem>> for ObserverError {
    fn from(problems: Vec<Problem>) -> Self {
        Self(problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; "))
    }
}

/// An observer: told of frames as they come, in order within a stream.
///
/// Frames of several streams of one window come one after the other, in no order that could be relied
/// on; a lossless observer may rely on each coming, a lossy one must not. Only what
/// [`Description::watches`] asks for comes.
pub trait Observer: Sized {
    /// Name and version of the program, for the log.
    const PROGRAM: &'static str;

    /// Checks the parameters and says what the observer needs; nothing is opened yet.
    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>>;

    /// Opens outputs. Called once, when the assignment is known.
    fn open(setup: &Setup) -> Result<Self, ObserverError>;

    /// All bodies at one moment; `from` is the sending component.
    fn bodies(
        &mut self,
        from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError>;

    /// All vertices of the scene's deformable surfaces at one moment. Comes only to observers that ask for
    /// them.
    fn surfaces(
        &mut self,
        _from: &str,
        _at: Moment,
        _samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        Ok(())
    }

    /// A cut through a field.
    fn slice(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError>;

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

    /// Signals of a component, in the order of `names`.
    fn signals(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError>;

    /// A line of the log.
    fn log(&mut self, at: Moment, header: &LogHeader, text: &str) -> Result<(), ObserverError>;

    /// The run is over and every frame was delivered; `last_common_window` is the last one that all
    /// components completed. Returns a note for the run's summary. What the observer serves may stay
    /// up until it is dropped.
    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError>;
}
