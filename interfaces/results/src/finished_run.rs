//! A finished run.

use crate::{SIGNALS, Signals, UnreadableSignals};
use std::path::{Path, PathBuf};
use tremie_messages::scene::Scene;

/// A run that has ended, read from its folder.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedRun {
    /// Its folder.
    pub folder: PathBuf,
    /// Its signals over time: at least one row.
    pub signals: Signals,
    /// Its scene, as its components were given it.
    pub scene: Scene,
}

/// Signals of a run that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum NoSignals {
    /// The table cannot be read.
    #[error("{0}\nOUT is the folder of a run, with its {SIGNALS}")]
    Unreadable(#[from] UnreadableSignals),
    /// The run ended before its first row.
    #[error("{}: its {SIGNALS} has no whole row", .0.display())]
    Empty(PathBuf),
}

/// The signals of the run in a folder, with at least one row. Its last row may have been cut off:
/// [`Signals::cut`] says so.
///
/// # Errors
/// A table that cannot be read, or is empty.
pub fn signals_of(folder: &Path) -> Result<Signals, NoSignals> {
    let signals = Signals::read(&folder.join(SIGNALS))?;
    if signals.times.is_empty() {
        return Err(NoSignals::Empty(folder.to_path_buf()));
    }
    Ok(signals)
}

/// Name of a run: that of its folder.
pub fn run_name(folder: &Path) -> String {
    let absolute = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    absolute
        .file_name()
        .map_or_else(|| folder.display().to_string(), |n| n.to_string_lossy().into())
}
