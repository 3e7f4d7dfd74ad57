//! Settings of a user.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Parameters of the tables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// The folder, relative to the run's output folder.
    pub folder: PathBuf,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { folder: "profiles".into() }
    }
}

impl Parameters {
    pub(crate) fn path(&self, output: &str) -> PathBuf {
        Path::new(output).join(&self.folder)
    }
}
