//! Two recordings compared: the first window and channel whose hashes differ, and what differs there.
//!
//! Both files are read side by side, frame by frame: memory holds little more than a frame of each.

use crate::differences::{Differences, of_frames, of_messages};
use crate::entry::topic;
use crate::item::Item;
use crate::recording::{Items, ReadError, Recording};
use crate::windows::Stream;
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use tremie_messages::Stamp;
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

/// Comparison of the hashes of two runs.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct HashComparison {
    /// Windows of which some channel was compared; the start exchange is one.
    pub windows: u64,
    /// Channels that were compared.
    pub channels: Vec<Channel>,
    /// The first window with different hashes. Windows count from 1; 0 is the start exchange.
    pub window: Option<u64>,
    /// The channels that differ in it, in the order of the window's work.
    pub differing: Vec<Channel>,
    /// Channels that only one of the runs has hashes of.
    pub unmatched: Vec<Channel>,
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

/// Hashes of one channel that wait for those of the other run: window and hash.
#[derive(Default)]
struct Waiting {
    rows: [VecDeque<(u64, u64)>; 2],
    /// The last window that was compared.
    compared: Option<u64>,
}

/// Compares hashes up to the first window that differs.
fn compare_hashes(items: &mut [Items; 2]) -> Result<HashComparison, ReadError> {
    let mut all: BTreeMap<Channel, Waiting> = BTreeMap::new();
    let mut found = HashComparison::default();
    let mut read = [Some(0), Some(0)];
    // The one that is behind is read next, so that little waits.
    while let Some(which) = behind(read) {
        match items[which].next().transpose()? {
            None => read[which] = None,
            Some(Item::Hashes { from, at, channels, rows }) => {
                read[which] = Some(at.stamp.window);
                take_rows(&mut all, which, (&from, &channels), &rows);
                compare_waiting(&mut all, &mut found);
            }
            Some(_) => {}
        }
        let is_past = |waiting: &Waiting| waiting.compared >= found.window;
        if found.window.is_some() && all.values().all(is_past) {
            break;
        }
    }
    let was_compared = |waiting: &Waiting| waiting.compared.is_some();
    let names = |wanted: bool| {
        let of = all.iter().filter(|(_, waiting)| was_compared(waiting) == wanted);
        of.map(|(channel, _)| channel.clone()).collect()
    };
    (found.channels, found.unmatched) = (names(true), names(false));
    let last = all.values().filter_map(|waiting| waiting.compared).max();
    found.windows = last.map_or(0, |last| last + 1);
    Ok(found)
}

/// The recording that is behind in what was read, of those that have more.
fn behind(read: [Option<u64>; 2]) -> Option<usize> {
    match read {
        [None, None] => None,
        [Some(_), None] => Some(0),
        [None, Some(_)] => Some(1),
        [Some(one), Some(other)] => Some(usize::from(other < one)),
    }
}

fn take_rows(
    all: &mut BTreeMap<Channel, Waiting>,
    which: usize,
    (from, channels): (&str, &[SentChannel]),
    rows: &[u64],
) {
    for (k, channel) in channels.iter().enumerate() {
        let waiting = all.entry(Channel::new(from, channel)).or_default();
        let of_channel = rows.chunks_exact(1 + channels.len()).map(|row| (row[0], row[1 + k]));
        waiting.rows[which].extend(of_channel);
    }
}

/// Compares what both have by now; windows that one run alone has are passed over.
fn compare_waiting(all: &mut BTreeMap<Channel, Waiting>, found: &mut HashComparison) {
    for (channel, Waiting { rows: [one, other], compared }) in all {
        while let (Some(&(a, hash)), Some(&(b, their))) = (one.front(), other.front()) {
            if a <= b {
                one.pop_front();
            }
            if b <= a {
                other.pop_front();
            }
            if a != b || found.window.is_some_and(|window| a > window) {
                *compared = (*compared).max(Some(a.min(b)));
                continue;
            }
            *compared = Some(a);
            if hash == their {
                continue;
            }
            if found.window != Some(a) {
                (found.window, found.differing) = (Some(a), Vec::new());
            }
            found.differing.push(channel.clone());
            found.differing.sort();
        }
    }
}

/// The message of a window that differs first, of the channels whose hashes do; `None` where not both
/// recordings have the messages.
fn find_in_messages(
    open: &impl Fn(usize) -> Result<Recording, ReadError>,
    window: u64,
    channels: &[Channel],
) -> Result<Option<Place>, ReadError> {
    let mut messages = [BTreeMap::new(), BTreeMap::new()];
    for (which, messages) in messages.iter_mut().enumerate() {
        let recording = open(which)?;
        if !channels.iter().all(|channel| recording.has_messages(&channel.from)) {
            return Ok(None);
        }
        let topics: Vec<String> = channels.iter().map(Channel::topic).collect();
        let items = recording.items_of(move |topic| topics.iter().any(|known| known == topic));
        *messages = messages_of(items, window)?;
    }
    let [one, other] = messages;
    let none = Vec::new();
    let first = channels.iter().filter_map(|channel| {
        let of = |messages: &'_ BTreeMap<Channel, Messages>| {
            messages.get(channel).cloned().unwrap_or_else(|| none.clone())
        };
        first_difference(channel, &of(&one), &of(&other))
    });
    Ok(first.min_by_key(|(order, _)| *order).map(|(_, place)| place))
}

/// Messages of one channel in a window, with their stamps.
type Messages = Vec<(Stamp, Vec<u8>)>;

fn messages_of(items: Items, window: u64) -> Result<BTreeMap<Channel, Messages>, ReadError> {
    let mut found: BTreeMap<Channel, Messages> = BTreeMap::new();
    for item in items {
        match item? {
            Item::Message { at, .. } if at.stamp.window > window => break,
            Item::Message { from, at, channel, values } if at.stamp.window == window => {
                let channel = Channel::new(&from, &channel);
                found.entry(channel).or_default().push((at.stamp, values));
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Place of a message in the work of its window: those inside it come before its end, substep by
/// substep and trial by trial.
fn order(content: Content, stamp: &Stamp) -> (bool, u32, u32, usize) {
    let all = Content::ALL.iter();
    let rank = all.take_while(|other| **other != content).count();
    match content.is_inside_window() {
        true => (false, stamp.substep, stamp.trial(), rank),
        false => (true, 0, 0, rank),
    }
}

/// The first message of a channel that differs, with its place in the window.
fn first_difference(
    channel: &Channel,
    one: &Messages,
    other: &Messages,
) -> Option<((bool, u32, u32, usize), Place)> {
    let content = channel.content;
    let place = |stamp: &Stamp, differences: Differences| {
        let place = Place {
            at: channel.to_string(),
            window: stamp.window,
            substep: stamp.substep,
            trial: stamp.trial(),
            is_message: true,
            differences,
        };
        Some((order(content, stamp), place))
    };
    let words = |others: String| Differences { others: vec![others], ..Differences::default() };
    for ((stamp, values), (theirs, their_values)) in one.iter().zip(other) {
        if stamp != theirs {
            return place(stamp, words(format!("the first sent {stamp}, the second {theirs}")));
        }
        let differences = of_messages(content, values, their_values);
        if !differences.is_empty() {
            return place(stamp, differences);
        }
    }
    let (count, their_count) = (one.len(), other.len());
    let extra = one.get(their_count).or(other.get(count))?;
    let said = format!("the first sent {count} messages in this window, the second {their_count}");
    place(&extra.0, words(said))
}

/// Frames of one window, by topic.
type Frames = BTreeMap<String, Item>;

/// Frames of a recording, window by window.
struct Windows {
    items: Items,
    next: Option<Item>,
}

impl Windows {
    /// The frames that show the physics.
    fn of_frames(recording: Recording) -> Self {
        const KINDS: [&str; 4] = ["/bodies/", "/surfaces/", "/cuts/", "/signals/"];
        let shows = |topic: &str| KINDS.iter().any(|kind| topic.starts_with(kind));
        Self { items: recording.items_of(shows), next: None }
    }

    /// The frames of the next window from `from` on.
    fn next(&mut self, from: u64) -> Result<Option<(u64, Frames)>, ReadError> {
        let mut frames: Option<(u64, Frames)> = None;
        loop {
            let item = match self.next.take() {
                Some(item) => item,
                None => match self.items.next().transpose()? {
                    Some(item) => item,
                    None => return Ok(frames),
                },
            };
            let window = item.window();
            if window < from {
                continue;
            }
            let (begun, of_window) = frames.get_or_insert_with(|| (window, Frames::new()));
            if window != *begun {
                self.next = Some(item);
                return Ok(frames);
            }
            of_window.insert(item.topic(), item);
        }
    }
}

/// The first frames from a window on that both recordings have and that differ.
fn find_in_frames(windows: &mut [Windows; 2], from: u64) -> Result<Option<Place>, ReadError> {
    let [one, other] = windows;
    let (mut a, mut b) = (one.next(from)?, other.next(from)?);
    while let (Some((window, frames)), Some((their, their_frames))) = (&a, &b) {
        if window == their {
            for (topic, frame) in frames {
                let Some(same) = their_frames.get(topic) else { continue };
                let differences = of_frames(frame, same);
                if !differences.is_empty() {
                    let (at, window) = (topic.clone(), *window);
                    let (substep, trial, is_message) = (0, 0, false);
                    let place = Place { at, window, substep, trial, is_message, differences };
                    return Ok(Some(place));
                }
            }
        }
        let (step, their_step) = (window <= their, their <= window);
        if step {
            a = one.next(from)?;
        }
        if their_step {
            b = other.next(from)?;
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channels() -> Vec<SentChannel> {
        let channel = |content| SentChannel { content, to: "fluid".into() };
        vec![channel(Content::State), channel(Content::Events)]
    }

    /// Compares rows of two runs that come in frames of other lengths.
    fn compare(one: &[u64], other: &[u64]) -> HashComparison {
        let (mut all, mut found) = (BTreeMap::new(), HashComparison::default());
        for row in one.chunks(3) {
            take_rows(&mut all, 0, ("grains", &channels()), row);
            compare_waiting(&mut all, &mut found);
        }
        for rows in other.chunks(6) {
            take_rows(&mut all, 1, ("grains", &channels()), rows);
            compare_waiting(&mut all, &mut found);
        }
        found
    }

    #[test]
    fn the_first_window_and_all_its_channels_are_found() {
        let one = [0, 7, 8, 1, 9, 10, 2, 11, 12, 3, 13, 14];
        assert_eq!(compare(&one, &one).window, None);
        let mut other = one;
        (other[7], other[8], other[10]) = (0, 0, 0);
        let found = compare(&one, &other);
        assert_eq!(found.window, Some(2));
        let names: Vec<_> = found.differing.iter().map(ToString::to_string).collect();
        assert_eq!(names, ["grains -> fluid, events", "grains -> fluid, state"]);
    }

    #[test]
    fn a_channel_that_differs_earlier_counts_though_it_is_looked_at_later() {
        let one = [0, 7, 8, 1, 9, 10, 2, 11, 12];
        let mut other = one;
        // Events, which are looked at first, differ in window 2, the state in window 1.
        (other[8], other[4]) = (0, 0);
        let found = compare(&one, &other);
        assert_eq!((found.window, found.differing.len()), (Some(1), 1));
        assert_eq!(found.differing[0].content, Content::State);
    }

    #[test]
    fn windows_of_one_run_alone_are_passed_over() {
        let found = compare(&[0, 7, 8, 2, 11, 12], &[0, 7, 8, 1, 9, 10, 2, 11, 0]);
        assert_eq!(found.window, Some(2));
    }
}
