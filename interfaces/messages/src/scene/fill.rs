//! Regions that hold fluid at the start.

use serde::{Deserialize, Serialize};

/// A region that holds fluid at the start: what of a box is inside a part, if one is named. The
/// fluid of a scene with such regions has a free surface; without any it fills its space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// Lower corner [m].
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Name of the part inside whose surface the fluid is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Velocity there at the start [m/s]; that of the whole fluid where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[f64; 3]>,
}

impl Fill {
    /// True if a point [m] lies in the box, its faces included.
    pub fn box_holds(&self, point: [f64; 3]) -> bool {
        (0..3).all(|a| self.min[a] <= point[a] && point[a] <= self.max[a])
    }
}
