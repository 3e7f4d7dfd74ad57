//! A finished run.

use crate::Signals;
use std::path::{Path, PathBuf};
use tremie_messages::scene::Scene;

/// A run that has ended, read from its folder.
#[derive(Clone, Debug, PartialEq)]
pub struct FinishedRun {
    /// Its folder.
    pub folder: PathBuf,
    /// Its signals over time: at least one row.
    pub signals: Signals,
    /// Its scene, from the manifest as resolved.
    pub scene: Scene,
}

/// Name of a run: that of its folder.
pub fn run_name(folder: &Path) -> String {
    let absolute = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    absolute
        .file_name()
        .map_or_else(|| folder.display().to_string(), |n| n.to_string_lossy().into())
}
