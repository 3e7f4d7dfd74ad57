//! Errors of channels.

/// A channel could not be opened, or did not take or give a message.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChannelError {
    /// Something could not be opened or created.
    #[error("cannot open {what}: {why}")]
    Open {
        /// The channel or folder.
        what: String,
        /// iceoryx2's reason.
        why: String,
    },
    /// The message is larger than the channel was made for.
    #[error("a message of {found} values does not fit channel {channel}, made for {capacity}")]
    Capacity {
        /// The channel.
        channel: String,
        /// Values in the message.
        found: usize,
        /// Values that fit.
        capacity: usize,
    },
    /// The receiver did not make room in time.
    #[error("channel {channel} stayed full: its receiver takes nothing")]
    Full {
        /// The channel.
        channel: String,
    },
    /// Anything else that iceoryx2 reports.
    #[error("channel {channel} failed: {why}")]
    Failed {
        /// The channel.
        channel: String,
        /// iceoryx2's reason.
        why: String,
    },
}

impl ChannelError {
    pub(crate) fn open(what: &str, why: impl std::fmt::Debug) -> Self {
        let mut why = format!("{why:?}");
        if why.contains("DataSegment") {
            why += ": the system gives no memory for it; look at its limits (ulimit -v) and at /dev/shm";
        }
        Self::Open { what: what.to_string(), why }
    }

    pub(crate) fn failed(channel: &str, why: impl std::fmt::Debug) -> Self {
        Self::Failed { channel: channel.to_string(), why: format!("{why:?}") }
    }
}
