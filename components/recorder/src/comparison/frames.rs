//! The first frames that differ.

use super::Place;
use crate::differences::of_frames;
use crate::item::Item;
use crate::recording::{Items, ReadError, Recording};
use std::collections::BTreeMap;

/// Frames of one window, by topic.
type Frames = BTreeMap<String, Item>;

/// Frames of a recording, window by window.
pub(super) struct Windows {
    pub(super) items: Items,
    next: Option<Item>,
}

impl Windows {
    /// The frames that show the physics.
    pub(super) fn of_frames(recording: Recording) -> Self {
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
pub(super) fn find_in_frames(
    windows: &mut [Windows; 2],
    from: u64,
) -> Result<Option<Place>, ReadError> {
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
