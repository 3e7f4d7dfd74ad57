//! Messages with their frames, on their way into the file or into a state.

use crate::proto::Frame;
use crate::signals::bytes;
use crate::windows::Stream;
use serde::{Deserialize, Serialize};
use tremie_sdk::state::{StateError, StateExchange};

/// Topic of the log.
pub const LOG: &str = "/log";

/// Topic of a stream, or of the log.
pub fn topic(stream: Option<&Stream>) -> String {
    match stream {
        None => LOG.into(),
        Some(Stream::Bodies(from)) => format!("/bodies/{from}"),
        Some(Stream::Surfaces(from)) => format!("/surfaces/{from}"),
        Some(Stream::Cut(from, name)) => format!("/cuts/{from}/{name}"),
        Some(Stream::Signals(from)) => format!("/signals/{from}"),
        Some(Stream::Hashes(from)) => format!("/hashes/{from}"),
        Some(Stream::Messages(from, content, to)) => {
            format!("/messages/{from}/{}/{to}", content.name())
        }
    }
}

/// A message, with the frame that announces it.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Stream of the message; `None` of a line of the log.
    pub stream: Option<Stream>,
    /// Window of the frame.
    pub window: u64,
    /// Simulated time [ns].
    pub time: u64,
    /// The encoded frame.
    pub frame: Vec<u8>,
    /// The encoded message.
    pub data: Vec<u8>,
}

impl Entry {
    /// A message of a stream, or a line of the log, after its frame.
    pub fn new(stream: Option<Stream>, frame: &Frame, time: u64, data: Vec<u8>) -> Self {
        Self { stream, window: frame.window, time, frame: bytes(frame), data }
    }
}

/// An entry without its bytes.
#[derive(Serialize, Deserialize)]
struct Head {
    stream: Option<Stream>,
    window: u64,
    time: u64,
    frame: usize,
    data: usize,
}

/// Keeps entries, or puts back what was kept; then those that are there do not matter. Their bytes are
/// one array: as values they would go into the state one by one.
///
/// # Errors
/// A damaged state.
pub fn exchange_entries<'a>(
    state: &mut StateExchange<'_>,
    name: &str,
    entries: impl Iterator<Item = &'a Entry>,
) -> Result<Vec<Entry>, StateError> {
    let (mut heads, mut bytes) = (Vec::new(), Vec::new());
    for Entry { stream, window, time, frame, data } in entries {
        let (stream, window, time) = (stream.clone(), *window, *time);
        heads.push(Head { stream, window, time, frame: frame.len(), data: data.len() });
        bytes.extend_from_slice(frame);
        bytes.extend_from_slice(data);
    }
    state.value(&format!("{name}.heads"), &mut heads)?;
    state.list(&format!("{name}.bytes"), &mut bytes)?;
    if !state.restores() {
        return Ok(Vec::new());
    }
    let mut rest = bytes.as_slice();
    let mut take = |length: usize| {
        let (taken, left) = rest.split_at_checked(length)?;
        rest = left;
        Some(taken.to_vec())
    };
    let entry = |Head { stream, window, time, frame, data }| {
        Some(Entry { stream, window, time, frame: take(frame)?, data: take(data)? })
    };
    let entries: Option<Vec<Entry>> = heads.into_iter().map(entry).collect();
    entries.filter(|_| rest.is_empty()).ok_or_else(|| StateError::Damaged {
        name: format!("{name}.bytes"),
        why: "they are not as long as their messages".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_sdk::state::{KeepsState, SavedState};

    struct Kept(Vec<Entry>);

    impl KeepsState for Kept {
        const STATE_VERSION: u32 = 1;

        fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
            let entries = exchange_entries(state, "waiting", self.0.iter())?;
            if state.restores() {
                self.0 = entries;
            }
            Ok(())
        }
    }

    #[test]
    fn entries_come_back_from_a_state() {
        let entry = |stream, window, data: &[u8]| Entry {
            stream,
            window,
            time: 7 * window,
            frame: vec![window as u8; 3],
            data: data.into(),
        };
        let mut before = Kept(vec![
            entry(Some(Stream::Cut("fluid".into(), "mid".into())), 3, &[1, 2, 3]),
            entry(None, 5, &[]),
        ]);
        let saved = SavedState::of(&mut before).unwrap();
        let mut after = Kept(vec![entry(None, 1, &[9])]);
        saved.restore(&mut after).unwrap();
        assert_eq!(after.0, before.0);
    }
}
