//! The manifest's tables of probes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::Length;

/// A place where the run measures fluid and grains. Exactly one of `point`, `line`, `section`,
/// `profile`, `region` and `ring`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ProbeTable {
    /// Name, unique in the scene: letters, digits, `_`. Required.
    pub name: Option<String>,
    /// A point: pressure and velocity of the fluid, interpolated.
    pub point: Option<[Length; 3]>,
    /// A line: their means along it.
    pub line: Option<LineTable>,
    /// A rectangle across an axis: rate of flow of the fluid alone, positive along the axis, and
    /// mean pressure; mass and number of grains that pass.
    pub section: Option<SectionTable>,
    /// A rectangle across an axis, cut into strips: mean velocity of the fluid along the axis in
    /// each of them.
    pub profile: Option<ProfileTable>,
    /// A box: means of pressure, velocity and solid fraction; fraction, number and velocity of
    /// grains.
    pub region: Option<RegionTable>,
    /// A hollow cylinder: the same of the fluid; number of grains, their area as seen along its
    /// axis, and that over its own.
    pub ring: Option<ProbeRingTable>,
}

/// The space between two radii about a line, and between two heights on it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ProbeRingTable {
    /// The line's axis. Required.
    pub axis: Option<AxisName>,
    /// A point of the line. Required.
    pub through: Option<[Length; 3]>,
    /// Inner and outer radius. Required.
    pub radii: Option<[Length; 2]>,
    /// Where it begins and ends along the line, from the point. Required.
    pub heights: Option<[Length; 2]>,
}

/// A straight line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct LineTable {
    /// One end. Required.
    pub from: Option<[Length; 3]>,
    /// The other. Required.
    pub to: Option<[Length; 3]>,
}

/// A rectangle across an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SectionTable {
    /// The axis. Required.
    pub axis: Option<AxisName>,
    /// Where on the axis. Required.
    pub at: Option<Length>,
    /// Lower corner; the entry along the axis has no meaning (default: the domain's).
    pub min: Option<[Length; 3]>,
    /// Upper corner (default: the domain's).
    pub max: Option<[Length; 3]>,
}

/// A rectangle across an axis, cut into strips along another.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ProfileTable {
    /// The axis, along which velocities count. Required.
    pub axis: Option<AxisName>,
    /// Where on the axis. Required.
    pub at: Option<Length>,
    /// The axis along which strips follow each other. Required.
    pub along: Option<AxisName>,
    /// How many strips, 1 to 64 (default: 16).
    pub bins: Option<u32>,
    /// Lower corner; the entry along the axis has no meaning (default: the domain's).
    pub min: Option<[Length; 3]>,
    /// Upper corner (default: the domain's).
    pub max: Option<[Length; 3]>,
}

/// An axis of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum AxisName {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

impl AxisName {
    /// Its number: 0, 1, 2.
    pub fn number(self) -> usize {
        self as usize
    }
}

/// A box.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RegionTable {
    /// Lower corner. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner. Required.
    pub max: Option<[Length; 3]>,
}
