//! What a user can set.

use rerun::MemoryLimit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tremie_messages::Problem;
use tremie_messages::units::Velocity;

/// Where the run is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// A page for the browser, served by this program on loopback.
    #[default]
    Web,
    /// The `rerun` program, which must be installed.
    Native,
    /// A recording that `rerun` opens later.
    File,
}

/// Parameters of the viewer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Where the run is shown.
    pub mode: Mode,
    /// The recording of mode `file`, relative to the run's output folder.
    pub file: PathBuf,
    /// Port of the page; another free one is taken if it is in use.
    pub web_port: u16,
    /// Port of the data; another free one is taken if it is in use.
    pub grpc_port: u16,
    /// Whether to open the page in the browser.
    pub open: bool,
    /// Most memory that the server keeps of the run, as "512 MB" or "25 %"; the oldest frames go first.
    pub memory_limit: String,
    /// Speed at the upper end of the colour scale; follows the run if unset.
    pub max_speed: Option<Velocity>,
    /// Whether to draw cuts.
    pub cuts: bool,
    /// About how many arrows to draw on a cut; 0 for none.
    pub arrows: u32,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            mode: Mode::Web,
            file: "run.rrd".into(),
            web_port: 9090,
            grpc_port: 9876,
            open: false,
            memory_limit: "1 GB".into(),
            max_speed: None,
            cuts: true,
            arrows: 400,
        }
    }
}

impl Parameters {
    /// Checks what the types cannot.
    ///
    /// # Errors
    /// Every problem found.
    pub fn check(&self) -> Result<(), Vec<Problem>> {
        let mut problems = Vec::new();
        if let Err(message) = self.memory() {
            problems.push(
                Problem::of_parameter("memory_limit", message)
                    .help("give an amount as \"512 MB\" or a share as \"25 %\""),
            );
        }
        if self.max_speed.is_some_and(|speed| speed.0 <= 0.0) {
            problems.push(Problem::of_parameter("max_speed", "must be positive"));
        }
        if self.mode == Mode::Web && self.web_port != 0 && self.web_port == self.grpc_port {
            problems.push(Problem::of_parameter(
                "grpc_port",
                "is the port of the page too; the two must differ",
            ));
        }
        if problems.is_empty() { Ok(()) } else { Err(problems) }
    }

    /// Most memory that the server keeps.
    pub(crate) fn memory(&self) -> Result<MemoryLimit, String> {
        let compact: String = self.memory_limit.split_whitespace().collect();
        MemoryLimit::parse(&compact)
            .map_err(|_| format!("\"{}\" is not an amount of memory", self.memory_limit))
    }

    /// The recording of mode `file`.
    pub(crate) fn recording(&self, output: &str) -> PathBuf {
        Path::new(output).join(&self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_and_shares_of_memory_are_read() {
        for text in ["512 MB", "1GB", "25 %", "50%", "2GiB"] {
            let parameters = Parameters { memory_limit: text.into(), ..Default::default() };
            assert!(parameters.check().is_ok(), "{text}");
        }
        let wrong = Parameters { memory_limit: "much".into(), ..Default::default() };
        assert_eq!(wrong.check().unwrap_err()[0].key, "@memory_limit");
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(serde_json::from_str::<Parameters>(r#"{"mode": "web", "prot": 1}"#).is_err());
        let parameters: Parameters = serde_json::from_str(r#"{"mode": "file"}"#).unwrap();
        assert_eq!(parameters.recording("/out"), Path::new("/out/run.rrd"));
    }
}
