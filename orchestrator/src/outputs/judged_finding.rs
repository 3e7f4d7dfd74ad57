//! Findings and their makers.

use serde::Serialize;
use tremie_messages::Finding;

/// A finding and who made it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JudgedFinding {
    /// The component, or [`WHOLE`].
    pub component: String,
    /// What it found.
    #[serde(flatten)]
    pub finding: Finding,
}

/// Who made findings about the run as a whole.
pub const WHOLE: &str = "run";

impl JudgedFinding {
    /// A finding about the run as a whole.
    pub fn of_whole(finding: Finding) -> Self {
        Self { component: WHOLE.into(), finding }
    }
}
