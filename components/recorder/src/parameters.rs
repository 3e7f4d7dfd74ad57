//! Settings of a user.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tremie_messages::Problem;

/// Parameters of the recorder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// The file, relative to the run's output folder.
    pub file: PathBuf,
    /// Level of compression (zstd), 1 (fast) to 19 (small).
    pub compression: u32,
    /// Keep every message between components, too; `outputs.messages` says so to the built-in one.
    pub messages: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { file: "run.mcap".into(), compression: 3, messages: false }
    }
}

impl Parameters {
    /// Checks what the types cannot.
    ///
    /// # Errors
    /// Every problem found.
    pub fn check(&self) -> Result<(), Vec<Problem>> {
        if (1..=19).contains(&self.compression) {
            return Ok(());
        }
        let message = format!("found {}, expected 1 to 19", self.compression);
        Err(vec![Problem::of_parameter("compression", message)])
    }

    pub(crate) fn path(&self, output: &str) -> PathBuf {
        Path::new(output).join(&self.file)
    }
}
