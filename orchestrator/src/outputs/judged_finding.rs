//! Findings and their makers.

use serde::Serialize;
use tremie_messages::Finding;

/// A finding with its maker.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedFinding {
    /// The component, or [`WHOLE`].
    pub component: String,
    /// The finding.
    #[serde(flatten)]
    pub finding: Finding,
}

/// Maker of findings about the run as a whole.
pub const WHOLE: &str = "run";

impl JudgedFinding {
    /// A finding about the run as a whole.
    pub fn of_whole(finding: Finding) -> Self {
        Self { component: WHOLE.into(), finding }
    }
}
