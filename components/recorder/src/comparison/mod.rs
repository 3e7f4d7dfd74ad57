//! Two recordings compared: the first window and channel whose hashes differ, and what differs there.
//!
//! Both files are read side by side, frame by frame: memory holds little more than a frame of each.

mod frames;
mod hashes;
mod messages;

use crate::differences::Differences;
use crate::entry::topic;
use crate::recording::{Items, ReadError, Recording};
use crate::windows::Stream;
use frames::{Windows, find_in_frames};
pub use hashes::HashComparison;
use hashes::compare_hashes;
use messages::find_in_messages;
use serde::Serialize;
use tremie_messages::schedule::Content;
use tremie_messages::start::SentChannel;

/// A channel between two components.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Channel {
    /// Sender.
    pub from: String,
    /// Receiver.
    pub to: String,
    /// Content of its messages.
    pub content: Content,
}

impl Channel {
    fn new(from: &str, channel: &SentChannel) -> Self {
        Self { from: from.into(), to: channel.to.clone(), content: channel.content }
    }

    /// Place in the order of a window's work.
    fn rank(&self) -> usize {
        let all = Content::ALL.iter();
        all.take_while(|content| **content != self.content).count()
    }

    fn topic(&self) -> String {
        topic(Some(&Stream::Messages(self.from.clone(), self.content, self.to.clone())))
    }
}

impl PartialOrd for Channel {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// What comes first in a window comes first: it may be the cause of what comes later.
impl Ord for Channel {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let key = |channel: &Self| (channel.rank(), channel.from.clone(), channel.to.clone());
        key(self).cmp(&key(other))
    }
}

impl std::fmt::Display for Channel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} -> {}, {}", self.from, self.to, self.content.name())
    }
}

/// What differs in two recordings.
#[derive(Clone, Debug, Serialize)]
pub struct Place {
    /// Where it was found: a channel, or the topic of a frame.
    pub at: String,
    /// Window of the message or frame.
    pub window: u64,
    /// Of messages inside a window: the substep; else that of the window's end.
    pub substep: u32,
    /// Of messages inside a window: the trial; else 0.
    pub trial: u32,
    /// True if messages were compared, false if frames were: these come at their own rate, and what
    /// they show may have begun earlier.
    pub is_message: bool,
    /// What differs.
    pub differences: Differences,
}

/// Two recordings, compared.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Hashes, where both have some.
    pub hashes: Option<HashComparison>,
    /// The first thing that differs, where it could be found.
    pub place: Option<Place>,
    /// The last window of each recording, where it was read to its end.
    pub last: [Option<u64>; 2],
    /// True of a recording that was found to be cut off.
    pub cut: [bool; 2],
}

/// Compares two recordings, of which `open` opens the first and the second.
///
/// # Errors
/// A recording that cannot be read.
pub fn compare(
    open: impl Fn(usize) -> Result<Recording, ReadError>,
) -> Result<Comparison, ReadError> {
    let both = [open(0)?, open(1)?];
    let (mut hashes, mut from) = (None, 0);
    if both.iter().all(Recording::has_hashes) {
        let mut items = both.map(|one| one.items_of(|topic| topic.starts_with("/hashes/")));
        let compared = compare_hashes(&mut items)?;
        if let Some(window) = compared.window {
            let place = find_in_messages(&open, window, &compared.differing)?;
            if place.is_some() {
                return Ok(Comparison::new(Some(compared), place, &items));
            }
            from = window;
        }
        hashes = Some(compared);
    }
    // Also where the hashes are equal: what no message tells may differ, as far from all bodies.
    let mut windows = [open(0)?, open(1)?].map(Windows::of_frames);
    let place = find_in_frames(&mut windows, from)?;
    Ok(Comparison::new(hashes, place, &windows.map(|windows| windows.items)))
}

impl Comparison {
    /// With the ends of two recordings, which are known where they were read to the end.
    fn new(hashes: Option<HashComparison>, place: Option<Place>, items: &[Items; 2]) -> Self {
        let ends = items.each_ref().map(Items::reached);
        let last = ends.map(|end| end.map(|end| end.last_common_window));
        let cut = ends.map(|end| end.is_some_and(|end| !end.complete));
        Self { hashes, place, last, cut }
    }
}
