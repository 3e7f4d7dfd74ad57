//! Why a component leaves its step loop before the end.

use tremie_channels::ChannelError;
use tremie_messages::start::{Fault, FaultKind};

/// Why a component leaves its step loop before the end.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// The orchestrator said so; nothing of this component's doing.
    Aborted,
    /// Something failed.
    Fault(Fault),
    /// A channel failed; the caller knows where and makes it a fault.
    Channel(ChannelError),
}

impl From<ChannelError> for Stop {
    fn from(error: ChannelError) -> Self {
        Stop::Channel(error)
    }
}

impl Stop {
    /// The fault that this amounts to, seen by `component` in `window`; `None` if it was aborted.
    pub fn into_fault(self, component: &str, window: u64) -> Option<Fault> {
        match self {
            Stop::Aborted => None,
            Stop::Fault(fault) => Some(fault),
            Stop::Channel(error) => Some(Fault {
                kind: FaultKind::Channel,
                noticed_by: component.to_string(),
                blamed: component.to_string(),
                window,
                message: error.to_string(),
            }),
        }
    }
}
