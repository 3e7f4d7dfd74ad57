//! Changes that a user made to a run, so that it can be made again: `steering.jsonl`, a JSON document a
//! line, and beside it the manifest with which the run began.

use super::folder::OutputError;
use super::{BEGUN, STEERING};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, Write};
use std::path::Path;
use tremie_state::write_whole;

/// A change of the manifest.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChangeRecord {
    /// Window from whose end on it holds.
    pub window: u64,
    /// Keys and values.
    pub set: Vec<(String, String)>,
}

/// Reads the changes of a run.
///
/// # Errors
/// What is wrong, with its line.
pub fn read_changes(path: &Path) -> Result<Vec<ChangeRecord>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut changes: Vec<ChangeRecord> = Vec::new();
    for (line, text) in (1..).zip(text.lines()) {
        let wrong = |why: String| format!("{}:{line}: {why}", path.display());
        let change: ChangeRecord =
            serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        let before = changes.last().map_or(0, |last| last.window);
        if change.window <= before {
            let found = change.window;
            return Err(wrong(format!("found window {found}, expected one after {before}")));
        }
        changes.push(change);
    }
    Ok(changes)
}

/// Adds a change to the record of the run in `out`; `before` is its manifest without the change.
///
/// # Errors
/// If the disk refuses.
pub fn record_change(out: &Path, before: &str, change: &ChangeRecord) -> Result<(), OutputError> {
    let begun = out.join(BEGUN);
    if !begun.exists() {
        write_whole(&begun, |file| file.write_all(before.as_bytes()))
            .map_err(OutputError::at(&begun))?;
    }
    let mut changes = forget_changes(out, change.window)?;
    match changes.iter_mut().find(|known| known.window == change.window) {
        // Two changes in one place: a run that was resumed there once more.
        Some(known) => known.set.extend(change.set.iter().cloned()),
        None => changes.push(change.clone()),
    }
    write(out, &changes)
}

/// Forgets changes after `window`, where the run goes on from that window; returns those that stay.
///
/// # Errors
/// If the disk refuses.
pub fn forget_changes(out: &Path, window: u64) -> Result<Vec<ChangeRecord>, OutputError> {
    let path = out.join(STEERING);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let changes = read_changes(&path)
        .map_err(|why| OutputError::at(&path)(io::Error::new(io::ErrorKind::InvalidData, why)))?;
    let (stay, gone): (Vec<_>, Vec<_>) =
        changes.into_iter().partition(|change| change.window <= window);
    if !gone.is_empty() {
        write(out, &stay)?;
    }
    Ok(stay)
}

fn write(out: &Path, changes: &[ChangeRecord]) -> Result<(), OutputError> {
    let path = out.join(STEERING);
    if changes.is_empty() {
        let gone = fs::remove_file(&path).and_then(|()| fs::remove_file(out.join(BEGUN)));
        return gone.map_err(OutputError::at(&path));
    }
    let lines = changes.iter().map(|change| serde_json::to_string(change).map(|line| line + "\n"));
    let text: Result<String, _> = lines.collect();
    text.map_err(io::Error::from)
        .and_then(|text| write_whole(&path, |file| file.write_all(text.as_bytes())))
        .map_err(OutputError::at(&path))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change(window: u64, key: &str) -> ChangeRecord {
        ChangeRecord { window, set: vec![(key.into(), "1".into())] }
    }

    #[test]
    fn changes_are_recorded_and_forgotten_from_a_window_on() {
        let out = tempfile::tempdir().unwrap();
        assert_eq!(forget_changes(out.path(), 5).unwrap(), []);
        for (window, key) in [(3, "a"), (8, "b"), (8, "c")] {
            record_change(out.path(), "begun", &change(window, key)).unwrap();
        }
        let read = || read_changes(&out.path().join(STEERING)).unwrap();
        let [a, b, c] = ["a", "b", "c"].map(|key| (key.to_string(), "1".to_string()));
        let both = ChangeRecord { window: 8, set: vec![b, c] };
        assert_eq!(read(), [ChangeRecord { window: 3, set: vec![a] }, both]);
        // The run went on from window 5 once more.
        record_change(out.path(), "later", &change(5, "d")).unwrap();
        assert_eq!(read().iter().map(|change| change.window).collect::<Vec<_>>(), [3, 5]);
        assert_eq!(fs::read_to_string(out.path().join(BEGUN)).unwrap(), "begun");
        assert_eq!(forget_changes(out.path(), 2).unwrap(), []);
        assert!(fs::read_dir(out.path()).unwrap().next().is_none(), "nothing was changed");
    }

    #[test]
    fn a_record_with_a_flaw_is_refused_with_its_line() {
        let out = tempfile::tempdir().unwrap();
        let path = out.path().join("changes");
        for (text, why) in [
            (
                "{\"window\":3,\"set\":[]}\n{\"window\":3,\"set\":[]}\n",
                ":2: found window 3, expected one after 3",
            ),
            ("{\"window\":0,\"set\":[]}\n", ":1: found window 0"),
            ("{\"window\":3}\n", ":1: missing field `set`"),
            ("fast\n", ":1: expected"),
        ] {
            fs::write(&path, text).unwrap();
            let error = read_changes(&path).unwrap_err();
            assert!(error.contains(why), "{error}");
        }
    }
}
