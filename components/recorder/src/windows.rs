//! Windows that are whole.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tremie_messages::schedule::Content;
use tremie_messages::start::{FrameContent, FrameStream, SentChannel};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};

/// A component that has completed this many windows more has seen the others complete one: coupled
/// components wait for each other's messages of the window before (serial) or of the one before
/// that (parallel).
pub const HOLD: u64 = 2;

/// Key of a stream at the recorder: kind, sender, name. Frames of a window are written in this
/// order.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Stream {
    /// All bodies.
    Bodies(String),
    /// All vertices of deformable surfaces.
    Surfaces(String),
    /// A cut, by sender and name.
    Cut(String, String),
    /// Signals.
    Signals(String),
    /// Hashes of messages.
    Hashes(String),
    /// Messages, by sender, content and receiver.
    Messages(String, Content, String),
}

impl Stream {
    /// Messages from a component on a channel.
    pub fn of_channel(from: &str, channel: &SentChannel) -> Self {
        Self::Messages(from.into(), channel.content, channel.to.clone())
    }

    /// The streams that frames of a content from a component belong to.
    fn of_content(from: &str, content: &FrameContent) -> Vec<Self> {
        let sender = from.to_string();
        match content {
            FrameContent::Bodies => vec![Self::Bodies(sender)],
            FrameContent::Surfaces => vec![Self::Surfaces(sender)],
            FrameContent::Slice(name) => vec![Self::Cut(sender, name.clone())],
            FrameContent::Signals(_) => vec![Self::Signals(sender)],
            FrameContent::Hashes(_) => vec![Self::Hashes(sender)],
            FrameContent::Messages(channels) => {
                channels.iter().map(|channel| Self::of_channel(from, channel)).collect()
            }
            FrameContent::Log
            | FrameContent::Loads
            | FrameContent::Timings(_)
            | FrameContent::Volume(_)
            | FrameContent::Profile(_) => Vec::new(),
        }
    }
}

/// Follows the lossless streams.
#[derive(Debug)]
pub struct Progress {
    /// Windows between frames of a stream, and the next window that it will have a frame of.
    due: BTreeMap<Stream, (u64, u64)>,
    newest: u64,
}

impl Progress {
    /// Of these streams; those that may lose frames are waited for by nobody.
    pub fn new(frames: &[FrameStream]) -> Self {
        let due = frames.iter().filter(|frame| frame.lossless).flat_map(|frame| {
            let streams = Stream::of_content(&frame.from, &frame.content);
            streams.into_iter().map(|stream| (stream, (frame.every.max(1), 0)))
        });
        Self { due: due.collect(), newest: 0 }
    }

    /// A frame of `window` arrived.
    pub fn arrived(&mut self, stream: &Stream, window: u64) {
        self.newest = self.newest.max(window);
        if let Some((every, due)) = self.due.get_mut(stream) {
            *due = window + *every;
        }
    }

    /// True if every frame of `window` is there and every component has completed it.
    pub fn is_whole(&self, window: u64) -> bool {
        window + HOLD <= self.newest && self.due.values().all(|(_, due)| *due > window)
    }
}

impl KeepsState for Progress {
    const STATE_VERSION: u32 = 1;

    /// Which streams there are and how often they have frames is for the run to say that goes on.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let next = |(stream, (_, due)): (&Stream, &(u64, u64))| (stream.clone(), *due);
        let mut kept: BTreeMap<Stream, u64> = self.due.iter().map(next).collect();
        state.value("due", &mut kept)?;
        state.value("newest", &mut self.newest)?;
        for (stream, next) in kept {
            if let Some((_, due)) = self.due.get_mut(&stream) {
                *due = next;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(from: &str, content: FrameContent, every: u64) -> FrameStream {
        FrameStream {
            from: from.into(),
            to: "recorder".into(),
            content,
            every,
            lossless: true,
            service: String::new(),
            capacity: 0,
            depth: 1,
        }
    }

    #[test]
    fn a_window_is_whole_when_all_that_is_due_came_and_others_moved_on() {
        let mut progress = Progress::new(&[
            frame("grains", FrameContent::Bodies, 10),
            frame("fluid", FrameContent::Signals(Vec::new()), 1),
        ]);
        let (bodies, signals) = (Stream::Bodies("grains".into()), Stream::Signals("fluid".into()));
        for window in 0..=5 {
            progress.arrived(&signals, window);
        }
        assert!(!progress.is_whole(0), "bodies of the start are missing");
        progress.arrived(&bodies, 0);
        assert!(progress.is_whole(0));
        assert!(progress.is_whole(3), "bodies are next due at window 10");
        assert!(!progress.is_whole(4), "other components may still be in window 4");
    }
}
