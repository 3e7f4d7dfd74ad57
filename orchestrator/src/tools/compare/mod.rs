//! `tremie diff`: what differs between two runs, and where it begins.

mod signals;

pub use signals::{SignalComparison, SignalDifference, compare_signals};

use crate::manifest::{self, ManifestErrors};
use crate::outputs::{RECORDING, SUMMARY};
use crate::registry::{ReadError, Recording, RecordingComparison, compare_recordings};
use serde::Serialize;
use std::path::Path;
use tremie_results::{SIGNALS, Signals};

/// Why two runs cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A manifest cannot be read.
    #[error("{0}")]
    Manifest(Box<ManifestErrors>),
    /// There is nothing that both left.
    #[error("nothing can be compared: {0}")]
    Nothing(String),
    /// A recording is damaged.
    #[error("{path}: {error}")]
    Recording {
        /// The recording.
        path: String,
        /// What is wrong with it.
        error: ReadError,
    },
}

/// Two runs, compared. Differences between the manifests are told, and do not make the runs differ: the
/// number of threads is one of them.
#[derive(Debug, Serialize)]
pub struct RunComparison {
    /// Keys in which the manifests differ.
    pub manifest: Vec<String>,
    /// The last window of each run, where it is known.
    pub windows: [Option<u64>; 2],
    /// The recordings, where both are there.
    pub recordings: Option<RecordingComparison>,
    /// The tables of signals, where both are there.
    pub signals: Option<SignalComparison>,
    /// What could not be compared, in sentences.
    pub notes: Vec<String>,
}

/// Compares the runs in two folders.
///
/// # Errors
/// See [`CompareError`].
pub fn compare_runs(outs: [&Path; 2]) -> Result<RunComparison, CompareError> {
    // Runs are compared wherever they were brought: files of their scenes may not be there.
    let load =
        |out| manifest::load_tables(out).map_err(|errors| CompareError::Manifest(errors.into()));
    let [one, other] = [load(outs[0])?, load(outs[1])?];
    let mut notes = Vec::new();
    let recordings = recordings(outs, &mut notes)?;
    let signals = tables(outs, &mut notes);
    if recordings.is_none() && signals.is_none() {
        return Err(CompareError::Nothing(notes.join("; ")));
    }
    let of_recording = |which: usize| recordings.as_ref().and_then(|both| both.last[which]);
    let windows = [0, 1].map(|which| windows_of(outs[which]).or_else(|| of_recording(which)));
    let manifest = manifest::differences(&one, &other);
    Ok(RunComparison { manifest, windows, recordings, signals, notes })
}

/// Compares the recordings; `None`, with a note, where not both are there.
fn recordings(
    outs: [&Path; 2],
    notes: &mut Vec<String>,
) -> Result<Option<RecordingComparison>, CompareError> {
    let paths = outs.map(|out| out.join(RECORDING));
    let mut are_there = true;
    for path in &paths {
        if let Err(error) = Recording::open(path) {
            notes.push(format!("{}: {error}", path.display()));
            are_there = false;
        }
    }
    if !are_there {
        return Ok(None);
    }
    let compared = compare_recordings(|which| Recording::open(&paths[which]));
    let compared = compared.map_err(|error| CompareError::Recording {
        path: paths.each_ref().map(|path| path.display().to_string()).join(" or "),
        error,
    })?;
    if compared.hashes.is_none() {
        notes.push("not both recordings have hashes: frames were compared".into());
    }
    for (path, _) in paths.iter().zip(compared.cut).filter(|(_, cut)| *cut) {
        notes.push(format!("{} is cut off: it was compared up to there", path.display()));
    }
    Ok(Some(compared))
}

/// Compares the tables of signals; `None`, with a note, where not both are there.
fn tables(outs: [&Path; 2], notes: &mut Vec<String>) -> Option<SignalComparison> {
    let [one, other] = outs.map(|out| Signals::read(&out.join(SIGNALS)));
    for error in [&one, &other].into_iter().filter_map(|table| table.as_ref().err()) {
        notes.push(error.to_string());
    }
    let (one, other) = (one.ok()?, other.ok()?);
    for cut in [&one, &other].into_iter().filter_map(|table| table.cut.as_ref()) {
        notes.push(cut.to_string());
    }
    Some(compare_signals(&one, &other))
}

/// The last window of a run, from its summary.
fn windows_of(out: &Path) -> Option<u64> {
    let text = std::fs::read_to_string(out.join(SUMMARY)).ok()?;
    serde_json::from_str::<serde_json::Value>(&text).ok()?.get("windows")?.as_u64()
}

impl RunComparison {
    /// True if the runs are the same as far as both went, in all that was compared.
    pub fn agrees(&self) -> bool {
        let recordings = self.recordings.as_ref().is_none_or(|both| {
            let hashes = both.hashes.as_ref();
            let same = hashes.is_none_or(|h| h.window.is_none() && h.unmatched.is_empty());
            same && both.place.is_none()
        });
        let signals =
            self.signals.as_ref().is_none_or(|both| both.count == 0 && both.unmatched.is_empty());
        recordings && signals
    }

    /// True if the runs are the same, and of the same length.
    pub fn is_equal(&self) -> bool {
        self.agrees() && self.windows[0] == self.windows[1]
    }

    /// What was found, in lines for a person; the last is the verdict.
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> =
            self.manifest.iter().map(|key| format!("manifest: {key} differs")).collect();
        lines.extend(self.notes.iter().map(|note| format!("note: {note}")));
        lines.extend(self.recordings.iter().flat_map(recording_lines));
        lines.extend(self.signals.iter().flat_map(signal_lines));
        lines.push(self.verdict());
        lines
    }

    /// The verdict, a line.
    pub fn verdict(&self) -> String {
        match (self.agrees(), self.windows) {
            (true, [one, other]) if one == other => {
                format!("equal: {}", self.compared().join("; "))
            }
            (true, [Some(one), Some(other)]) => {
                let (longer, shorter) = if one > other { (1, 2) } else { (2, 1) };
                format!(
                    "equal up to window {}, where OUT{shorter} ends; OUT{longer} goes on to window {}",
                    one.min(other),
                    one.max(other)
                )
            }
            (true, _) => format!(
                "equal as far as both go ({}); the last window of one is not known",
                self.compared().join("; ")
            ),
            (false, _) => self.beginning(),
        }
    }

    /// Where runs that differ begin to.
    fn beginning(&self) -> String {
        let both = self.recordings.as_ref();
        let hashes = both.and_then(|both| both.hashes.as_ref());
        let differing = hashes.and_then(|hashes| Some((hashes.window?, hashes.differing.first()?)));
        let from = |window: u64| match window {
            0 => "from the start".to_string(),
            window => format!("from window {window} on"),
        };
        if let Some((window, channel)) = differing {
            return format!("the runs differ {}: {channel}", from(window));
        }
        match both.and_then(|both| both.place.as_ref()) {
            Some(place) => {
                let though = if hashes.is_some() { ", though in no message" } else { "" };
                format!("the runs differ {}{though}: {}", from(place.window), place.at)
            }
            None => "the runs differ: see above".into(),
        }
    }

    /// How much was compared.
    fn compared(&self) -> Vec<String> {
        let hashes = self.recordings.as_ref().map(|both| match &both.hashes {
            Some(hashes) => {
                let windows = hashes.windows.saturating_sub(1);
                let channels = hashes.channels.len();
                format!("{windows} windows, hashes of {channels} channels, frames")
            }
            None => "frames".into(),
        });
        let signals = self.signals.as_ref();
        let table = signals.map(|both| format!("{} rows of {} signals", both.rows, both.signals));
        hashes.into_iter().chain(table).collect()
    }
}

fn recording_lines(both: &RecordingComparison) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(hashes) = &both.hashes {
        let alone = hashes.unmatched.iter();
        lines.extend(alone.map(|channel| format!("hashes: one run alone has those of {channel}")));
        if let Some(window) = hashes.window {
            let names: Vec<String> = hashes.differing.iter().map(ToString::to_string).collect();
            let names = names.join("; ");
            lines.push(format!("hashes: window {window} is the first that differs, in {names}"));
        }
    }
    if let Some(place) = &both.place {
        let inside = match (place.is_message, place.trial) {
            (true, trial @ 1..) => format!(", substep {}, trial {trial}", place.substep),
            _ => String::new(),
        };
        let kind = if place.is_message { "message" } else { "frames" };
        let amount = place.differences.amount();
        lines.push(format!("{kind}: {}, window {}{inside}: {amount}", place.at, place.window));
        lines.extend(place.differences.lines().into_iter().map(|line| format!("  {line}")));
    } else if both.hashes.as_ref().is_some_and(|hashes| hashes.window.is_some()) {
        lines.push(
            "frames: none of both runs differs; record with outputs.messages = true to see what does"
                .into(),
        );
    }
    lines
}

fn signal_lines(both: &SignalComparison) -> Vec<String> {
    let alone = both.unmatched.iter();
    let mut lines: Vec<String> =
        alone.map(|name| format!("{SIGNALS}: one run alone has {name}")).collect();
    if let Some(time) = both.time {
        let count = both.count;
        lines.push(format!(
            "{SIGNALS}: the row of {time} s is the first that differs, in {count} of {} signals",
            both.signals
        ));
        lines.extend(both.first.iter().map(|SignalDifference { name, unit, one, other }| {
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            format!("  {name}: {one:?} and {other:?}{unit}")
        }));
        if count > both.first.len() {
            lines.push(format!("  and {} more", count - both.first.len()));
        }
    }
    lines
}
