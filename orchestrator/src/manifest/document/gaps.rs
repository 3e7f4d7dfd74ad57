//! The manifest's tables of gaps.

use super::{AxisName, RegionTable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::Length;

/// A gap between two surfaces that may become thinner than the fluid resolves. At most one of
/// `pressure` and `pressure_at`, and of `region` and `ring`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct GapTable {
    /// Name, unique in the scene: letters, digits, `_`. Required.
    pub name: Option<String>,
    /// Between what: names of parts or surfaces, or faces of the domain as "lower x", "upper x" and
    /// so on. Required.
    pub between: Option<[String; 2]>,
    /// The thickness from which its cells are fluid, in cells; thinner, they are solid (default:
    /// 1.5, which suits a gap along the lattice; 2 suits a slanted one).
    pub open_at: Option<f64>,
    /// The thickness below which they are solid again, in cells (default: 0.5, or `open_at` if that
    /// is less).
    pub close_at: Option<f64>,
    /// What presses on both sides while the gap holds no fluid (default: nearest).
    pub pressure: Option<GapPressureName>,
    /// Probes whose mean pressure that is. Put them on either side of it: what the gap draws in as
    /// it widens leaves the fluid there.
    pub pressure_at: Option<Vec<String>>,
    /// Their weights (default: all alike).
    pub weights: Option<Vec<f64>>,
    /// The thickness below which its walls do not hold the fluid along themselves, in cells, if the
    /// fluid's viscosity is small (default: 0, they always do).
    pub slip_below: Option<f64>,
    /// The box in which it is (default: everywhere between the two).
    pub region: Option<RegionTable>,
    /// The ring in which it is.
    pub ring: Option<RingTable>,
}

/// What presses in a gap that holds no fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum GapPressureName {
    /// Nothing: gauge pressure zero.
    Zero,
    /// The mean of the fluid next to it.
    Nearest,
}

/// The space between two radii about a line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RingTable {
    /// The line's axis. Required.
    pub axis: Option<AxisName>,
    /// A point of the line. Required.
    pub through: Option<[Length; 3]>,
    /// Inner and outer radius. Required.
    pub radii: Option<[Length; 2]>,
}
