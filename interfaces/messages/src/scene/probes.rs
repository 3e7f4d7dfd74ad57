//! Probes: points, lines, sections, boxes and rings in which a run measures the flow.

use super::Ring;
use serde::{Deserialize, Serialize};

/// A place whose values are signals of the fluid and of the grains, named `probe.value`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Probe {
    /// Name, unique in the scene: letters, digits, `_`.
    pub name: String,
    /// Shape and place.
    pub shape: ProbeShape,
}

/// Shape and place of a probe.
///
/// The fluid's means are over its cells there; none counts that a body covers. The grains answer to
/// sections, regions and rings; where parts are solid does not enter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProbeShape {
    /// At a point [m], interpolated between cells: `pressure`, `velocity_x`, `velocity_y`,
    /// `velocity_z`.
    Point([f64; 3]),
    /// Mean along a line: the same values.
    Line {
        /// One end [m].
        from: [f64; 3],
        /// The other [m].
        to: [f64; 3],
    },
    /// A rectangle across an axis. Of the fluid: `flow_rate` [m³/s] along the axis, mean `pressure`
    /// [Pa], and `mass_flow_rate` [kg/s], mean over the time since the row before. Of the grains,
    /// counted as their centres pass: `mass_flow_rate` [kg/s] along the axis, mean over the window;
    /// `crossings`, the number that passed in the window, less the number that passed back;
    /// `mass_passed` [kg] since the start, likewise.
    Section {
        /// The axis: 0, 1, 2 for x, y, z.
        axis: usize,
        /// Position on the axis [m].
        position: f64,
        /// Lower corner; the entry along the axis has no meaning [m].
        min: [f64; 3],
        /// Upper corner [m].
        max: [f64; 3],
    },
    /// A rectangle across an axis, cut into strips along another. Of the fluid: `u0`, `u1`, ...,
    /// the mean velocity along the axis in each strip [m/s], in the order of the other axis.
    Profile {
        /// The axis: 0, 1, 2 for x, y, z.
        axis: usize,
        /// Position on the axis [m].
        position: f64,
        /// Lower corner; the entry along the axis has no meaning [m].
        min: [f64; 3],
        /// Upper corner [m].
        max: [f64; 3],
        /// The other axis.
        along: usize,
        /// Number of strips, 1 to [`ProbeShape::MOST_BINS`].
        bins: usize,
    },
    /// Mean over a box. Of the fluid: `pressure`, `velocity_x`, `velocity_y`, `velocity_z`, and
    /// `solid_fraction`, the part of its cells that moving bodies cover. Of the grains:
    /// `solid_fraction`, the part of its volume that spheres fill, by the volumes that they and the
    /// box have in common; `number` of centres in it; and `velocity_x`, `velocity_y`, `velocity_z`,
    /// the mean over the volume filled.
    Region {
        /// Lower corner [m].
        min: [f64; 3],
        /// Upper corner [m].
        max: [f64; 3],
    },
    /// In a ring. Of the fluid: the same means as in a box. Of the grains: `number` of centres in
    /// it; `projected_area` [m²] of their spheres, seen along the ring's axis; and `area_fraction`,
    /// that over the area of the ring's cross-section in the domain. Of a ring between a seat and
    /// what closes on it this is the normalised area of stuck particles (Mutabaruka & Kamrin 2018).
    Ring(Ring),
}

impl ProbeShape {
    /// Most strips of a profile.
    pub const MOST_BINS: usize = 64;
}
