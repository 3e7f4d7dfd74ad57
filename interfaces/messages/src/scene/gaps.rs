//! Gaps that open and close: the model of a gap too thin for a fluid to be resolved in it.

use serde::{Deserialize, Serialize};

/// A gap between two surfaces that may become thinner than a fluid resolves.
///
/// While it is, it holds no fluid: its cells are frozen, solid to the fluid around, and a pressure
/// acts on both surfaces by a rule. Where it is a little wider, its walls may slip. What is meant
/// in cells depends on the resolution, on purpose: it says what a lattice can do, not what the gap
/// is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gap {
    /// Name, unique in the scene.
    pub name: String,
    /// The two surfaces that bound it.
    pub between: [GapSide; 2],
    /// Thickness from which its cells are fluid [cells].
    pub open_at: f64,
    /// Thickness below which they are frozen again [cells]; at most `open_at`.
    pub close_at: f64,
    /// Rule for the pressure in it while it holds no fluid.
    pub pressure: GapRule,
    /// Thickness below which its walls let the fluid slip along them [cells]; 0: never.
    pub slip_below: f64,
    /// Region that it is limited to; `None`: everywhere between the two surfaces.
    pub region: Option<GapRegion>,
}

/// One side of a gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GapSide {
    /// A part or a deformable surface of the scene, by its name.
    Part(String),
    /// A face of the domain: axis 0, 1, 2 for x, y, z; side 0 for the lower, 1 for the upper.
    Face {
        /// Axis.
        axis: usize,
        /// Side.
        side: usize,
    },
}

/// Rule for the pressure in a gap that holds no fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GapRule {
    /// Gauge pressure zero.
    Zero,
    /// The mean over the fluid cells next to it.
    Nearest,
    /// The weighted mean of the pressures at probes. What the gap draws in as it widens a fluid may
    /// then take on their sides of it, by the same weights.
    Probes(Vec<GapWeight>),
}

/// A probe and its weight in the pressure of a gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GapWeight {
    /// Name of the probe.
    pub probe: String,
    /// Weight; those of a gap are divided by their sum.
    pub weight: f64,
}

/// Region of a gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GapRegion {
    /// In a box.
    Box {
        /// Lower corner [m].
        min: [f64; 3],
        /// Upper corner [m].
        max: [f64; 3],
    },
    /// Between two radii about a line along an axis.
    Ring {
        /// Axis of the line: 0, 1, 2 for x, y, z.
        axis: usize,
        /// A point of the line [m].
        through: [f64; 3],
        /// Inner and outer radius [m].
        radii: [f64; 2],
    },
}

impl GapRegion {
    /// True if a point [m] is in the region, its edges included.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        match self {
            Self::Box { min, max } => (0..3).all(|a| min[a] <= point[a] && point[a] <= max[a]),
            Self::Ring { axis, through, radii } => {
                let [b, c] = [(axis + 1) % 3, (axis + 2) % 3].map(|a| point[a] - through[a]);
                let square = b * b + c * c;
                radii[0] * radii[0] <= square && square <= radii[1] * radii[1]
            }
        }
    }
}
