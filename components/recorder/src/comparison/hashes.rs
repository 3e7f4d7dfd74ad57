//! Hashes of two recordings, compared up to the first window that differs.

use super::Channel;
use crate::item::Item;
use crate::recording::{Items, ReadError};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use tremie_messages::start::SentChannel;

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

/// Hashes of one channel that wait for those of the other run: window and hash.
#[derive(Default)]
struct Waiting {
    rows: [VecDeque<(u64, u64)>; 2],
    /// The last window that was compared.
    compared: Option<u64>,
}

/// Compares hashes up to the first window that differs.
pub(super) fn compare_hashes(items: &mut [Items; 2]) -> Result<HashComparison, ReadError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::schedule::Content;

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
