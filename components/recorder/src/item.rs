//! A frame as it was recorded.

use crate::entry::topic;
use crate::windows::Stream;
use tremie_messages::frame::{BodySample, LogHeader, SliceHeader, SliceNode, SurfaceSample};
use tremie_messages::start::{SentChannel, Signal};
use tremie_sdk::{CopiedMessage, Moment, Observer, ObserverError};

/// One call of an observer, as it was recorded.
#[derive(Clone, Debug, PartialEq)]
pub enum Item {
    /// All bodies at one moment.
    Bodies {
        /// Sender.
        from: String,
        /// When.
        at: Moment,
        /// The bodies.
        bodies: Vec<BodySample>,
    },
    /// All vertices of deformable surfaces at one moment.
    Surfaces {
        /// Sender.
        from: String,
        /// When.
        at: Moment,
        /// The vertices.
        samples: Vec<SurfaceSample>,
    },
    /// A cut through a field.
    Slice {
        /// Sender.
        from: String,
        /// Name of the cut.
        name: String,
        /// When.
        at: Moment,
        /// Its grid.
        header: SliceHeader,
        /// Its nodes.
        nodes: Vec<SliceNode>,
    },
    /// Signals of a component.
    Signals {
        /// Sender.
        from: String,
        /// When.
        at: Moment,
        /// Names and units.
        names: Vec<Signal>,
        /// Values.
        values: Vec<f64>,
    },
    /// Hashes of the messages of a component.
    Hashes {
        /// Sender.
        from: String,
        /// When.
        at: Moment,
        /// Channels of the messages.
        channels: Vec<SentChannel>,
        /// A window and a hash for each channel, again and again.
        rows: Vec<u64>,
    },
    /// A message between components.
    Message {
        /// Sender.
        from: String,
        /// When, with the stamp of the message but for the run's id.
        at: Moment,
        /// Its channel.
        channel: SentChannel,
        /// Its values as they lie in memory.
        values: Vec<u8>,
    },
    /// A line of the log.
    Log {
        /// When.
        at: Moment,
        /// Its level.
        header: LogHeader,
        /// The line.
        text: String,
    },
}

impl Item {
    /// Tells an observer.
    ///
    /// # Errors
    /// The observer's own.
    pub fn tell<O: Observer>(&self, observer: &mut O) -> Result<(), ObserverError> {
        match self {
            Item::Bodies { from, at, bodies } => observer.bodies(from, *at, bodies),
            Item::Surfaces { from, at, samples } => observer.surfaces(from, *at, samples),
            Item::Slice { from, name, at, header, nodes } => {
                observer.slice(from, name, *at, header, nodes)
            }
            Item::Signals { from, at, names, values } => observer.signals(from, *at, names, values),
            Item::Hashes { from, at, channels, rows } => observer.hashes(from, *at, channels, rows),
            Item::Message { from, at, channel, values } => {
                let message = CopiedMessage { channel: 0, stamp: at.stamp, values };
                observer.messages(from, *at, std::slice::from_ref(channel), &[message])
            }
            Item::Log { at, header, text } => observer.log(*at, header, text),
        }
    }

    /// Topic of the frame.
    pub fn topic(&self) -> String {
        let stream = match self {
            Item::Bodies { from, .. } => Stream::Bodies(from.clone()),
            Item::Surfaces { from, .. } => Stream::Surfaces(from.clone()),
            Item::Slice { from, name, .. } => Stream::Cut(from.clone(), name.clone()),
            Item::Signals { from, .. } => Stream::Signals(from.clone()),
            Item::Hashes { from, .. } => Stream::Hashes(from.clone()),
            Item::Message { from, channel, .. } => Stream::of_channel(from, channel),
            Item::Log { .. } => return topic(None),
        };
        topic(Some(&stream))
    }

    /// Window of the frame.
    pub fn window(&self) -> u64 {
        match self {
            Item::Bodies { at, .. }
            | Item::Surfaces { at, .. }
            | Item::Slice { at, .. }
            | Item::Signals { at, .. }
            | Item::Hashes { at, .. }
            | Item::Message { at, .. } => at.stamp.window,
            // Lines of the log may speak of windows that were not recorded.
            Item::Log { .. } => 0,
        }
    }

    /// Simulated time of its frame [s]; 0 of a line of the log, which has no frame.
    pub fn time(&self) -> f64 {
        match self {
            Item::Bodies { at, .. }
            | Item::Surfaces { at, .. }
            | Item::Slice { at, .. }
            | Item::Signals { at, .. }
            | Item::Hashes { at, .. }
            | Item::Message { at, .. } => at.time,
            Item::Log { .. } => 0.0,
        }
    }
}
