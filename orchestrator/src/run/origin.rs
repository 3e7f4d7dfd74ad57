//! Where a run begins that does not begin with its scene alone.

use crate::outputs::WholeCheckpoint;
use std::fmt::{Display, Formatter};
use tremie_messages::Role;
use tremie_messages::start::Resume;

/// The checkpoint from which a run begins.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// The checkpoint.
    pub checkpoint: &'a WholeCheckpoint,
    /// What the run takes of it.
    pub takes: Takes,
}

/// What a run takes of the checkpoint from which it begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Takes {
    /// All: the run is that of the checkpoint, and goes on with its outputs.
    Outputs,
    /// The states of all components: it goes on in time, and its outputs are its own.
    States,
    /// Bodies and contacts of the grains alone: it begins at time zero, with other components.
    Bodies,
}

impl Display for Origin<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let folder = self.checkpoint.folder().display();
        match self.takes {
            Takes::Outputs => write!(f, "the run goes on from {folder}"),
            Takes::States => write!(f, "the run begins from the states of {folder}"),
            Takes::Bodies => write!(f, "the run begins at time zero with the bodies of {folder}"),
        }
    }
}

impl<'a> Origin<'a> {
    /// The checkpoint, if the run is its.
    pub fn own(self) -> Option<&'a WholeCheckpoint> {
        (self.takes == Takes::Outputs).then_some(self.checkpoint)
    }

    /// Window at whose end the run begins; `None` if that is time zero.
    pub fn window(self) -> Option<u64> {
        (self.takes != Takes::Bodies).then_some(self.checkpoint.record.window)
    }

    /// What a component of a role is told of it.
    pub fn resume(self, role: Role) -> Option<Resume> {
        if self.takes == Takes::Bodies && role != Role::Grains {
            return None;
        }
        Some(Resume {
            window: self.checkpoint.record.window,
            folder: self.checkpoint.folder().to_string_lossy().into_owned(),
            same_outputs: self.takes == Takes::Outputs,
            bodies_only: self.takes == Takes::Bodies,
        })
    }
}
