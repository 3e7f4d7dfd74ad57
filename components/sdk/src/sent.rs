//! What a component has sent: hashes of its messages, and copies of them, for observers that ask.
//!
//! A hash costs a reading of the message and no memory. Rows of hashes wait for the next frame; they
//! are few, and part of the component's state. Copies are of the present window alone.

use std::cell::RefCell;
use tremie_messages::frame::MessageHead;
use tremie_messages::schedule::Edge;
use tremie_messages::start::{Assignment, FrameContent, SentChannel};
use tremie_messages::{Message, Stamp, bytes_of, values_of};
use tremie_state::{StateError, StateExchange};
use xxhash_rust::xxh64::xxh64;

/// Messages that a component has sent, as far as observers ask for them.
#[derive(Debug, Default)]
pub struct SentMessages {
    channels: Vec<SentChannel>,
    are_hashed: bool,
    are_copied: bool,
    /// Of the present window, by channel.
    hashes: Vec<u64>,
    /// Rows that no frame has taken yet: a window and its hashes.
    rows: Vec<u64>,
    /// Of the present window: heads and values.
    copies: Vec<u8>,
}

/// The same while ports send, each of which knows its context but does not own it.
pub type SharedSentMessages = RefCell<SentMessages>;

impl SentMessages {
    /// Of a component before its first message, with what its streams of frames ask for.
    pub fn new(component: &str, assignment: &Assignment) -> Self {
        let mut sent = Self::default();
        for stream in assignment.frames.iter().filter(|stream| stream.from == component) {
            let channels = match &stream.content {
                FrameContent::Hashes(channels) => {
                    sent.are_hashed = true;
                    sent.rows.reserve(stream.capacity as usize);
                    channels
                }
                FrameContent::Messages(channels) => {
                    sent.are_copied = true;
                    channels
                }
                _ => continue,
            };
            sent.channels.clone_from(channels);
        }
        sent.hashes = vec![0; sent.channels.len()];
        sent
    }

    /// Index of the channel of an edge; `None` if nobody asks for its messages.
    pub fn channel(&self, edge: &Edge) -> Option<usize> {
        let is_its =
            |channel: &SentChannel| channel.content == edge.content && channel.to == edge.to;
        self.channels.iter().position(is_its)
    }

    /// Takes note of a message of this component's present window.
    pub fn note<T: Message>(&mut self, channel: usize, stamp: &Stamp, values: &[T]) {
        // The run's id differs between equal runs.
        let (stamp, values) = (Stamp { run: 0, ..*stamp }, bytes_of(values));
        if self.are_hashed {
            let hash = &mut self.hashes[channel];
            *hash = xxh64(values, xxh64(bytes_of(&[stamp]), *hash));
        }
        if self.are_copied {
            let head = MessageHead { stamp, channel: channel as u64, bytes: values.len() as u64 };
            self.copies.extend_from_slice(bytes_of(&[head]));
            self.copies.extend_from_slice(values);
        }
    }

    /// The window has ended: its hashes become a row.
    pub fn end_window(&mut self, window: u64) {
        if self.are_hashed {
            self.rows.push(window);
            self.rows.append(&mut self.hashes);
            self.hashes.resize(self.channels.len(), 0);
        }
    }

    /// Rows that wait for a frame, as its values.
    pub fn rows(&self) -> &[u64] {
        &self.rows
    }

    /// A frame has taken the rows.
    pub fn forget_rows(&mut self) {
        self.rows.clear();
    }

    /// Copies of the present window's messages, as the values of frames.
    pub fn copies(&self) -> &[u8] {
        &self.copies
    }

    /// Frames have taken the copies.
    pub fn forget_copies(&mut self) {
        self.copies.clear();
    }

    /// Keeps the rows that wait, or puts them back.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.list("unsent_hashes", &mut self.rows)?;
        let row = 1 + self.channels.len();
        if !self.are_hashed {
            // A run that goes on without a recorder has nobody for them.
            self.rows.clear();
        } else if !self.rows.len().is_multiple_of(row) {
            let found = self.rows.len();
            return state.unfit(format!("found {found} words of hashes, expected rows of {row}"));
        }
        Ok(())
    }
}

/// A message as its sender copied it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CopiedMessage<'a> {
    /// Index into the list of channels that comes with it.
    pub channel: usize,
    /// Its stamp; the run's id is 0.
    pub stamp: Stamp,
    /// Its values as they lie in memory.
    pub values: &'a [u8],
}

impl<'a> CopiedMessage<'a> {
    /// All messages of a window from the values of its frames, with so many channels; `None` if they
    /// are none.
    pub fn all(mut bytes: &'a [u8], channels: usize) -> Option<Vec<Self>> {
        let mut all = Vec::new();
        while !bytes.is_empty() {
            let (head, rest) = bytes.split_at_checked(size_of::<MessageHead>())?;
            let MessageHead { stamp, channel, bytes: length } =
                values_of::<MessageHead>(head)?.pop()?;
            let (values, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
            let channel = usize::try_from(channel).ok().filter(|channel| *channel < channels)?;
            all.push(Self { channel, stamp, values });
            bytes = rest;
        }
        Some(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::schedule::Content;
    use tremie_messages::start::FrameStream;
    use tremie_messages::{BodyState, Load};

    fn asked(contents: &[fn(Vec<SentChannel>) -> FrameContent]) -> SentMessages {
        let channel = |content| SentChannel { content, to: "fluid".into() };
        let channels = vec![channel(Content::Events), channel(Content::State)];
        let stream = |content: &fn(Vec<SentChannel>) -> FrameContent| FrameStream {
            from: "grains".into(),
            to: "recorder".into(),
            content: content(channels.clone()),
            every: 1,
            lossless: true,
            service: String::new(),
            capacity: 6,
            depth: 1,
        };
        let frames: Vec<_> = contents.iter().map(stream).collect();
        let mut sent = SentMessages::default();
        for stream in &frames {
            match &stream.content {
                FrameContent::Hashes(_) => sent.are_hashed = true,
                _ => sent.are_copied = true,
            }
        }
        (sent.channels, sent.hashes) = (channels, vec![0; 2]);
        sent
    }

    fn body(x: f64) -> BodyState {
        BodyState::at_rest(7, [x, 0.0, 0.0])
    }

    #[test]
    fn hashes_tell_bits_and_order_and_not_the_run() {
        let row = |run: u64, values: &[f64]| {
            let mut sent = asked(&[FrameContent::Hashes]);
            for (k, x) in values.iter().enumerate() {
                let stamp = Stamp { run, window: 3, substep: k as u32, ..Stamp::default() };
                sent.note(1, &stamp, &[body(*x)]);
            }
            sent.end_window(3);
            sent.rows().to_vec()
        };
        let first = row(1, &[0.1, 0.2]);
        assert_eq!(first[..2], [3, 0], "no events were sent");
        assert_ne!(first[2], 0);
        assert_eq!(first, row(2, &[0.1, 0.2]));
        assert_ne!(first, row(1, &[0.1, 0.2_f64.next_up()]));
        assert_ne!(first, row(1, &[0.2, 0.1]));
        assert_ne!(first, row(1, &[0.1]));
        assert_ne!(row(1, &[0.0]), row(1, &[-0.0]));
    }

    #[test]
    fn a_hash_is_what_the_contract_says() {
        let mut sent = asked(&[FrameContent::Hashes]);
        let stamp = Stamp { run: 9, window: 1, ticks: 10, events: 1, substep: 4, iteration: 0 };
        sent.note(1, &stamp, &[body(0.5)]);
        sent.end_window(1);
        let words = [0_u64, 1, 10, 1, 4].map(u64::to_le_bytes).concat();
        let expected = xxh64(bytes_of(&[body(0.5)]), xxh64(&words, 0));
        assert_eq!(sent.rows()[2], expected);
    }

    #[test]
    fn copies_come_apart_again() {
        let mut sent = asked(&[FrameContent::Messages]);
        let stamp = |window| Stamp { run: 5, window, ..Stamp::default() };
        sent.note::<Load>(0, &stamp(1), &[]);
        sent.note(1, &stamp(1), &[body(0.1), body(0.2)]);
        sent.end_window(1);
        assert!(sent.rows().is_empty());
        let all = CopiedMessage::all(sent.copies(), 2).unwrap();
        assert_eq!(all.len(), 2);
        assert_eq!((all[0].channel, all[0].stamp.run, all[0].values.len()), (0, 0, 0));
        assert_eq!(values_of::<BodyState>(all[1].values).unwrap()[1], body(0.2));
        assert_eq!(CopiedMessage::all(sent.copies(), 1), None);
        let short = &sent.copies()[..sent.copies().len() - 1];
        assert_eq!(CopiedMessage::all(short, 2), None);
        sent.forget_copies();
        assert_eq!(CopiedMessage::all(sent.copies(), 2), Some(Vec::new()));
    }
}
