//! States in parts: of a component of several processes, each of which keeps its own in a file beside the first.

use crate::archive::StateHeader;
use crate::error::StateError;
use serde::{Deserialize, Serialize};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest time in which nothing of the parts that are waited for comes to the disk.
pub(crate) const PARTS_STAND_STILL: Duration = Duration::from_secs(60);

/// Time between looks at them.
const LOOK: Duration = Duration::from_millis(5);

/// Which part of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatePart {
    /// Its number; the first is 0, and has what all parts have alike.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Default for StatePart {
    /// The whole state.
    fn default() -> Self {
        Self { number: 0, of: 1 }
    }
}

/// The file of a state, or of the first of its parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatePlace {
    /// Its path.
    pub path: PathBuf,
    /// Whose state it is.
    pub header: StateHeader,
    /// What stands before the names of entries.
    pub within: String,
}

/// The rows of an array that a process has, of one that several have together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SharedRows {
    /// Rows of the whole array.
    pub all: usize,
    /// Those that it keeps. The processes' rows follow each other in the order of the parts.
    pub own: Range<usize>,
    /// Those that it wants back, in order.
    pub held: Vec<Range<usize>>,
}

impl SharedRows {
    /// All rows.
    pub fn whole(all: usize) -> Self {
        Self { all, own: 0..all, held: std::iter::once(0..all).collect() }
    }

    /// What it wants back of some rows.
    pub(crate) fn held_in(&self, span: &Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let within = |held: &Range<usize>| held.start.max(span.start)..held.end.min(span.end);
        self.held.iter().map(within).filter(|rows| !rows.is_empty())
    }
}

/// File of a part, beside the file of the first.
pub fn part_file(first: &Path, number: u32) -> PathBuf {
    first.with_extension(format!("part-{number}.npz"))
}

/// Length of a state's files, of all its parts that follow each other [bytes]; 0 without a first.
pub fn bytes_on_disk(first: &Path) -> u64 {
    let length = |path: PathBuf| std::fs::metadata(path).ok().map(|file| file.len());
    let Some(own) = length(first.to_path_buf()) else { return 0 };
    own + (1..).map_while(|number| length(part_file(first, number))).sum::<u64>()
}

/// Waits for the other parts of a state, and gives their length [bytes].
///
/// # Errors
/// A part whose process says why it could not be written; parts of which nothing came for the time `still`.
pub(crate) fn await_parts(first: &Path, parts: u32, still: Duration) -> Result<u64, StateError> {
    let (mut bytes, mut progress, mut changed) = (0, 0, Instant::now());
    let mut missing: Vec<u32> = (1..parts).collect();
    loop {
        let mut seen = bytes;
        let mut failed = None;
        missing.retain(|&number| {
            let path = part_file(first, number);
            if let Ok(file) = std::fs::metadata(&path) {
                bytes += file.len();
                seen += file.len();
                return false;
            }
            if let Ok(why) = std::fs::read_to_string(path.with_extension("failed")) {
                failed.get_or_insert(format!("part {number} was not written: {why}"));
            }
            seen += std::fs::metadata(path.with_extension("unfinished")).map_or(0, |f| f.len());
            true
        });
        if let Some(why) = failed {
            return Err(StateError::Unfit(why));
        }
        let Some(&number) = missing.first() else { return Ok(bytes) };
        if seen != progress {
            (progress, changed) = (seen, Instant::now());
        }
        if changed.elapsed() > still {
            let text = format!(
                "nothing came of it for {} s: is the folder on a file system that all processes share?",
                still.as_secs()
            );
            let error = io::Error::new(io::ErrorKind::TimedOut, text);
            return Err(StateError::Io { path: part_file(first, number), error });
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_that_do_not_come_or_fail_are_named() {
        let home = tempfile::tempdir().unwrap();
        let first = home.path().join("fluid.npz");
        let wait = |parts| await_parts(&first, parts, Duration::from_millis(60));
        assert_eq!(wait(1).unwrap(), 0);
        std::fs::write(part_file(&first, 1), "abc").unwrap();
        assert_eq!(wait(2).unwrap(), 3);
        let text = wait(3).unwrap_err().to_string();
        assert!(text.contains("fluid.part-2.npz") && text.contains("share"), "{text}");
        std::fs::write(part_file(&first, 2).with_extension("failed"), "no room").unwrap();
        let text = wait(3).unwrap_err().to_string();
        assert!(text.contains("part 2 was not written: no room"), "{text}");
        std::fs::write(&first, "ab").unwrap();
        assert_eq!(bytes_on_disk(&first), 5);
    }

    #[test]
    fn rows_that_are_wanted_of_a_part() {
        let rows = SharedRows { all: 100, own: 20..40, held: vec![0..5, 18..42, 90..100] };
        let of = |span: Range<usize>| rows.held_in(&span).collect::<Vec<_>>();
        assert_eq!(of(0..20), [0..5, 18..20]);
        assert_eq!(of(42..90), []);
        assert_eq!(of(40..95), [40..42, 90..95]);
    }
}
