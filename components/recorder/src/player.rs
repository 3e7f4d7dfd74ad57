//! A player of recorded messages: stands for a component in a run that is replayed.

use crate::differences::of_messages;
use crate::entry::topic;
use crate::item::Item;
use crate::recording::{Items, Recording};
use crate::windows::Stream;
use serde::Deserialize;
use std::collections::VecDeque;
use std::path::PathBuf;
use tremie_messages::Problem;
use tremie_messages::schedule::{Content, Edge};
use tremie_messages::start::{Description, SentChannel};
use tremie_sdk::{ControlPipe, RecordedMessage, RecordedMessages, Setup, play_recorded};

/// Windows that are kept behind the newest: a message is taken at most two windows late.
const BEHIND: u64 = 3;

/// Most numbers that are told of a message that differs: it is a line in a log.
const TOLD: usize = 3;

/// Parameters of the player, which the orchestrator sets.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlayerParameters {
    /// The recording.
    recording: PathBuf,
    /// Description of the component for which it stands.
    description: Description,
    /// The last window that is compared, if not all are.
    last_compared: Option<u64>,
}

/// A message with its window and stream.
type Kept = (u64, Stream, RecordedMessage);

/// Messages of a recording, read as windows go by.
struct Played {
    path: PathBuf,
    items: Items,
    /// Messages of the newest windows.
    kept: VecDeque<Kept>,
    /// The first message of a window that is not kept yet.
    next: Option<Kept>,
    is_read: bool,
    last_compared: u64,
}

impl Played {
    /// Reads everything up to a window.
    fn read_through(&mut self, window: u64) -> Result<(), String> {
        while !self.is_read {
            if self.next.as_ref().is_some_and(|(next, ..)| *next > window) {
                break;
            }
            self.kept.extend(self.next.take().filter(|(read, ..)| read + BEHIND >= window));
            match self.items.next() {
                None => self.is_read = true,
                Some(Err(error)) => return Err(format!("{}: {error}", self.path.display())),
                Some(Ok(Item::Message { from, at, channel, values })) => {
                    let stream = Stream::of_channel(&from, &channel);
                    let message = RecordedMessage { stamp: at.stamp, values };
                    self.next = Some((at.stamp.window, stream, message));
                }
                Some(Ok(_)) => {}
            }
        }
        while self.kept.front().is_some_and(|(old, ..)| old + BEHIND < window) {
            self.kept.pop_front();
        }
        Ok(())
    }
}

impl RecordedMessages for Played {
    const PROGRAM: &'static str = concat!("player ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        Ok(setup.parameters::<PlayerParameters>()?.description)
    }

    fn open(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let PlayerParameters { recording: path, last_compared, .. } = setup.parameters()?;
        let last_compared = last_compared.unwrap_or(u64::MAX);
        let stream = |edge: &Edge| {
            let channel = SentChannel { content: edge.content, to: edge.to.clone() };
            topic(Some(&Stream::of_channel(&edge.from, &channel)))
        };
        let topics: Vec<String> = setup.assigned()?.edges.iter().map(stream).collect();
        let recording = Recording::open(&path).map_err(|error| {
            vec![Problem::of_parameter("recording", format!("{}: {error}", path.display()))]
        })?;
        let items = recording.items_of(move |topic| topics.iter().any(|known| known == topic));
        Ok(Self { path, items, kept: VecDeque::new(), next: None, is_read: false, last_compared })
    }

    fn last_compared(&self) -> u64 {
        self.last_compared
    }

    fn messages(&mut self, window: u64, edge: &Edge) -> Result<Vec<RecordedMessage>, String> {
        self.read_through(window)?;
        let channel = SentChannel { content: edge.content, to: edge.to.clone() };
        let stream = Stream::of_channel(&edge.from, &channel);
        let of_window = self.kept.iter().filter(|(at, of, _)| *at == window && *of == stream);
        Ok(of_window.map(|(.., message)| message.clone()).collect())
    }

    fn difference(content: Content, recorded: &[u8], found: &[u8]) -> Option<String> {
        let differences = of_messages(content, recorded, found);
        let lines = differences.first_lines(TOLD).join("; ");
        (!differences.is_empty())
            .then(|| format!("{}, as recorded and now: {lines}", differences.amount()))
    }
}

/// Takes part in a replayed run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run_player(line: ControlPipe) -> Result<(), String> {
    play_recorded::<Played>(line)
}
