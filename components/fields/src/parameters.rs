//! Settings of a user.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tremie_messages::Problem;
use tremie_messages::start::VolumeWish;
use tremie_messages::units::Length;

/// How arrays are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Compression {
    /// As they are.
    None,
    /// In compressed blocks.
    #[default]
    Lz4,
}

/// A box whose nodes are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Lower corner.
    pub min: [Length; 3],
    /// Upper corner.
    pub max: [Length; 3],
}

/// Parameters of the fields.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// The folder, relative to the run's output folder.
    pub folder: PathBuf,
    /// Every so many nodes of a lattice along each axis.
    pub stride: u64,
    /// Only the nodes in this box; all, if it is not given.
    pub region: Option<Region>,
    /// How arrays are stored.
    pub compression: Compression,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            folder: "fields".into(),
            stride: 1,
            region: None,
            compression: Compression::default(),
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
        if self.stride == 0 {
            problems.push(Problem::of_parameter("stride", "found 0, expected 1 or more"));
        }
        if let Some(Region { min, max }) = &self.region
            && (0..3).any(|a| min[a].0 > max[a].0)
        {
            let message = format!(
                "its lower corner {:?} m is not below its upper corner {:?} m",
                min.map(|x| x.0),
                max.map(|x| x.0)
            );
            problems.push(Problem::of_parameter("region", message));
        }
        if problems.is_empty() { Ok(()) } else { Err(problems) }
    }

    /// Nodes of a lattice that are wanted.
    pub(crate) fn wish(&self) -> VolumeWish {
        let corners = |region: &Region| [region.min.map(|x| x.0), region.max.map(|x| x.0)];
        VolumeWish {
            stride: self.stride,
            most_nodes: None,
            region: self.region.as_ref().map(corners),
        }
    }

    pub(crate) fn path(&self, output: &str) -> PathBuf {
        Path::new(output).join(&self.folder)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_problems_come_at_once() {
        let text = r#"{"stride": 0, "region": {"min": ["1 mm", "0 m", "0 m"], "max": ["0 m", "1 m", "1 m"]}}"#;
        let parameters: Parameters = serde_json::from_str(text).unwrap();
        let keys: Vec<_> = parameters.check().unwrap_err().into_iter().map(|p| p.key).collect();
        assert_eq!(keys, ["@stride", "@region"]);
        let text = r#"{"region": {"min": ["1 mm", "0 m", "0 m"], "max": ["2 mm", "1 m", "1 m"]}}"#;
        let parameters: Parameters = serde_json::from_str(text).unwrap();
        assert!(parameters.check().is_ok());
        assert_eq!(parameters.wish().region, Some([[1e-3, 0.0, 0.0], [2e-3, 1.0, 1.0]]));
    }
}
