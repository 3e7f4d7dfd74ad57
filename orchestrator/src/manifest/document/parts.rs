//! The manifest's tables of rigid parts.

use super::AxisName;
use super::course::{CourseEntry, MotionCourseEntry};
use super::domain::ReservoirTable;
use super::slider::PartMotionEntry;
use super::values::FileUnit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Angle, AngularVelocity, Length, Pressure, Time, Velocity};

/// A rigid part with a closed surface. Exactly one of `file`, `box`, `cylinder`, `sphere`,
/// `revolved` and `extrusion`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PartTable {
    /// Name, unique among the parts: letters, digits, `-` and `_`. Required.
    pub name: Option<String>,
    /// A file of triangles, STL or OBJ; its path is relative to the manifest's folder.
    pub file: Option<String>,
    /// What one unit of the file is, as "mm". Required with a file.
    pub unit: Option<FileUnit>,
    /// A box about the origin of the part's frame.
    #[serde(rename = "box")]
    pub box_: Option<BoxTable>,
    /// A cylinder about the z axis of the part's frame, its middle at the origin.
    pub cylinder: Option<CylinderTable>,
    /// A sphere about the origin of the part's frame.
    pub sphere: Option<PartSphereTable>,
    /// A profile turned about the z axis of the part's frame.
    pub revolved: Option<RevolvedTable>,
    /// A prism along an axis of the part's frame.
    pub extrusion: Option<ExtrusionTable>,
    /// Where the origin of the part's frame is, of a slider at lift 0 (default: at the world's).
    pub position: Option<[Length; 3]>,
    /// How the part's frame is turned (default: not).
    pub rotation: Option<RotationTable>,
    /// Whether the space inside the surface is free and that outside solid (default: false).
    pub cavity: Option<bool>,
    /// Its material, for contacts (default: the domain's).
    pub material: Option<String>,
    /// How it moves, about the origin of its frame: fixed, prescribed, or a table with a slider
    /// (default: fixed).
    pub motion: Option<PartMotionEntry>,
    /// Velocity of a prescribed motion (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity of a prescribed motion (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
    /// Velocities of a prescribed motion over time, in place of constant ones; or a formula for
    /// their factor: `{ sine = { frequency = "2 Hz" } }`.
    pub course: Option<MotionCourseEntry>,
    /// What the part is to the fluid (default: a wall without slip).
    pub boundary: Option<BoundaryTable>,
}

/// A box about the origin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct BoxTable {
    /// Edge lengths. Required.
    pub size: Option<[Length; 3]>,
}

/// A cylinder about the z axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct CylinderTable {
    /// Radius. Required.
    pub radius: Option<Length>,
    /// Length along z. Required.
    pub length: Option<Length>,
}

/// A sphere about the origin.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PartSphereTable {
    /// Radius. Required.
    pub radius: Option<Length>,
}

/// A profile turned about the z axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RevolvedTable {
    /// Its corners, radius and z: `[["0 mm", "0 mm"], ["5 mm", "0 mm"], ["0 mm", "8 mm"]]` is a
    /// cone. The axis closes a profile that begins and ends on it; the last corner and the first
    /// close any other. Required.
    pub profile: Option<Vec<[Length; 2]>>,
}

/// A prism along an axis, its middle at the origin there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ExtrusionTable {
    /// Corners of its section, either way round, in the other two axes in their order: x and y along
    /// z, x and z along y. No edge may meet another. Required.
    pub outline: Option<Vec<[Length; 2]>>,
    /// The axis. Required.
    pub axis: Option<AxisName>,
    /// Length along the axis. Required.
    pub length: Option<Length>,
}

/// A rotation by the right-hand rule.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RotationTable {
    /// About this direction, of any length but zero. Required.
    pub axis: Option<[f64; 3]>,
    /// By this angle. Required.
    pub angle: Option<Angle>,
}

/// What a part is to the fluid. Exactly one of `velocity` and `pressure`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct BoundaryTable {
    /// The fluid leaves the part's surface with this velocity.
    pub velocity: Option<[Velocity; 3]>,
    /// The fluid comes and goes through the surface at this gauge pressure.
    pub pressure: Option<Pressure>,
    /// The fluid comes from a reservoir with a piston that is not simulated, through the one side of the
    /// part that the fluid touches, whichever way it faces.
    pub reservoir: Option<ReservoirTable>,
    /// Time in which velocity or pressure rise from zero (default: none).
    pub ramp: Option<Time>,
    /// Factor of velocity or pressure over time: points, `[["0 s", 0.0], ["1 s", 1.0]]`, or a
    /// formula.
    pub course: Option<CourseEntry>,
}
