//! The first message of a window that differs.

use super::{Channel, Place};
use crate::differences::{Differences, of_messages};
use crate::item::Item;
use crate::recording::{Items, ReadError, Recording};
use std::collections::BTreeMap;
use tremie_messages::Stamp;
use tremie_messages::schedule::Content;

/// The message of a window that differs first, of the channels whose hashes do; `None` where not both
/// recordings have the messages.
pub(super) fn find_in_messages(
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
