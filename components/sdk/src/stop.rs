//! Why a component leaves its step loop before the end.

use tremie_channels::ChannelError;
use tremie_messages::schedule::Edge;
use tremie_messages::start::{Fault, FaultKind};

/// Why a component leaves its step loop before the end.
#[derive(Clone, Debug, PartialEq)]
pub enum Stop {
    /// The orchestrator said so; nothing of this component's doing.
    Aborted,
    /// Something failed.
    Fault(Fault),
    /// A channel to the orchestrator failed; the caller knows in which window and makes it a fault.
    Channel(ChannelError),
}

impl From<ChannelError> for Stop {
    fn from(error: ChannelError) -> Self {
        Stop::Channel(error)
    }
}

impl Stop {
    /// The stop that an error on the channel of `edge` amounts to, seen by `component` in `window`.
    /// A channel that is full or broken tells of the peer at its other end; the rest is the
    /// component's own.
    pub fn on_edge(error: ChannelError, edge: &Edge, component: &str, window: u64) -> Self {
        let peer = if edge.from == component { &edge.to } else { &edge.from };
        let blamed = match &error {
            ChannelError::Full { .. } | ChannelError::Failed { .. } => peer,
            ChannelError::Open { .. } | ChannelError::Capacity { .. } => component,
        };
        Stop::Fault(Fault {
            kind: FaultKind::Channel,
            noticed_by: component.to_string(),
            blamed: blamed.to_string(),
            window,
            message: format!("on {}, {error}", edge.label()),
        })
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::schedule::Content;

    fn edge() -> Edge {
        Edge {
            from: "fluid".into(),
            to: "grains".into(),
            content: Content::Load,
            service: "fluid/load".into(),
            capacity: 1,
            depth: 2,
            sender_substeps: 1,
            events_lag: 0,
        }
    }

    fn fault(error: ChannelError, component: &str) -> Fault {
        Stop::on_edge(error, &edge(), component, 7).into_fault("nobody", 0).unwrap()
    }

    #[test]
    fn a_full_or_broken_channel_is_the_peers_fault() {
        let full = ChannelError::Full { channel: "fluid/load".into() };
        let found = fault(full, "fluid");
        assert_eq!((found.blamed.as_str(), found.noticed_by.as_str()), ("grains", "fluid"));
        assert_eq!(found.window, 7);
        assert!(found.message.contains("fluid -> grains, load"), "{found}");
        let failed = ChannelError::Failed { channel: "fluid/load".into(), why: "gone".into() };
        assert_eq!(fault(failed, "grains").blamed, "fluid");
    }

    #[test]
    fn a_message_that_does_not_fit_is_its_senders_own_fault() {
        let large = ChannelError::Capacity { channel: "fluid/load".into(), found: 2, capacity: 1 };
        assert_eq!(fault(large, "fluid").blamed, "fluid");
    }
}
