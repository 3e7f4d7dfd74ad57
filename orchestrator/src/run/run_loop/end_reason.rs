//! Reasons for which the loop of windows ends before all are done.

use crate::outputs::{Breach, OutputError};
use tremie_channels::ChannelError;
use tremie_messages::start::{Fault, FaultKind};

/// Reason for which the loop of windows ends before all are done.
pub(super) enum EndReason {
    /// A second interrupt: the run ends at once, not in order.
    Impatience,
    Fault(Box<Fault>),
    /// A watched quantity has passed its limit.
    Breach(Box<Breach>),
    Output(OutputError),
}

impl From<Fault> for EndReason {
    fn from(fault: Fault) -> Self {
        Self::Fault(Box::new(fault))
    }
}

impl From<OutputError> for EndReason {
    fn from(error: OutputError) -> Self {
        Self::Output(error)
    }
}

impl From<ChannelError> for EndReason {
    fn from(error: ChannelError) -> Self {
        Self::Fault(Box::new(Fault {
            kind: FaultKind::Channel,
            noticed_by: "the orchestrator".into(),
            blamed: "the orchestrator".into(),
            window: 0,
            message: error.to_string(),
        }))
    }
}
