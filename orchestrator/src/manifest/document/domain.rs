//! The manifest's tables of the domain, its faces, and the fluid.

use super::course::CourseEntry;
use super::forms::read_by_form;
use super::{AxisName, GasTable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::scene::{Outflow, Profile};
use tremie_messages::units::{
    Acceleration, Area, Density, Length, Pressure, Time, Velocity, Viscosity, Volume,
};

/// The box in which everything happens.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct DomainTable {
    /// Lower corner (default: zero).
    pub origin: Option<[Length; 3]>,
    /// Edge lengths. Required.
    pub size: Option<[Length; 3]>,
    /// What the two faces across x are (default: wall).
    pub x: Option<AxisEntry>,
    /// What the two faces across y are (default: wall).
    pub y: Option<AxisEntry>,
    /// What the two faces across z are (default: wall).
    pub z: Option<AxisEntry>,
    /// Makes the scene a plane one: the axis across the plane, along which nothing varies. Bodies
    /// are then cylinders across it, as long as the domain is deep (default: none, a scene in
    /// space).
    pub across: Option<AxisName>,
    /// Material of the faces, for contacts of grains (default: "wall").
    pub material: Option<String>,
}

/// The two faces of an axis: a name for both, or each by itself.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum AxisEntry {
    /// Both alike.
    Both(FaceName),
    /// Each by itself.
    Sides(Box<SidesTable>),
}

/// The two faces of an axis, each by itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SidesTable {
    /// The face at the lower end (default: wall).
    pub lower: Option<FaceEntry>,
    /// The face at the upper end (default: wall).
    pub upper: Option<FaceEntry>,
}

/// A face: a name, or one that moves or is open.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum FaceEntry {
    /// By its name.
    Name(FaceName),
    /// One that moves or is open.
    Table(Box<FaceTable>),
}

/// What a face is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum FaceName {
    /// No slip for the fluid, a plane for grains.
    Wall,
    /// Joined to the opposite face.
    Periodic,
    /// A mirror: no flow through it, no friction along it.
    Symmetry,
}

/// A face that moves or is open. Exactly one of `wall`, `velocity`, `pressure` and `reservoir`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct FaceTable {
    /// A wall that moves along itself.
    pub wall: Option<MovingWallTable>,
    /// The fluid enters, or leaves, with this velocity. To grains the face is a wall
    /// unless an outlet lies there.
    pub velocity: Option<[Velocity; 3]>,
    /// How the velocity varies over the face (default: uniform).
    pub profile: Option<Profile>,
    /// The fluid comes and goes at this gauge pressure, without its hydrostatic part. To grains the
    /// face is a wall unless an outlet lies there.
    pub pressure: Option<Pressure>,
    /// Whether sound, or the long waves of a fluid with a free surface, pass through a pressure face
    /// instead of being thrown back; the pressure then holds on average (default: false).
    pub absorbing: Option<bool>,
    /// Way in which what arrives from inside leaves through a pressure face (default: fixed);
    /// `absorbing = true` is short for `outflow = "absorbing"`.
    pub outflow: Option<Outflow>,
    /// Height of the free surface beyond a face with a velocity or a pressure, on the axis along
    /// which gravity acts: fluid enters below it, and the pressure is hydrostatic from there. For
    /// fluids with a free surface.
    pub level: Option<Length>,
    /// The fluid comes from a reservoir with a piston that is not simulated.
    pub reservoir: Option<ReservoirTable>,
    /// Time in which velocity or pressure rise from zero, that of a moving wall too (default:
    /// none).
    pub ramp: Option<Time>,
    /// Factor of velocity or pressure over time: linear between points, `[["0 s", 0.0], ["1 s",
    /// 1.0]]`, or a formula, `{ sine = { frequency = "2 Hz" } }`.
    pub course: Option<CourseEntry>,
}

/// A cylinder beyond the face or surface, of uniform density, closed by a piston. The physics depends on the
/// ratio of volume and area alone: where symmetry planes cut it, both may be those of the whole.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ReservoirTable {
    /// Area of the piston, which is that of the fluid at the face or surface. Required.
    pub area: Option<Area>,
    /// Volume between piston and face or surface at the start. Required.
    pub volume: Option<Volume>,
    /// Velocity of the piston towards the domain (default: it stands still).
    pub piston: Option<Velocity>,
    /// Time in which the piston's velocity rises from zero (default: none).
    pub ramp: Option<Time>,
    /// Factor of the piston's velocity over time: points, `[["0 s", 0.0], ["1 s", 1.0]]`, or a
    /// formula.
    pub course: Option<CourseEntry>,
    /// Time from which on the piston stands still (default: never).
    pub stop: Option<Time>,
    /// Part of its difference from the mean that the normal velocity of a cell at the face or surface
    /// loses in a step, from 0 to 1 (default: 0.02); 0 switches it off.
    pub relaxation: Option<f64>,
}

/// A wall that moves along itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct MovingWallTable {
    /// Its velocity. Required.
    pub velocity: Option<[Velocity; 3]>,
    /// Time in which it rises from zero (default: none).
    pub ramp: Option<Time>,
    /// Factor of the velocity over time: points, `[["0 s", 0.0], ["1 s", 1.0]]`, or a formula,
    /// `{ sine = { frequency = "2 Hz" } }`.
    pub course: Option<CourseEntry>,
}

read_by_form!(AxisEntry: "\"wall\", \"periodic\", \"symmetry\", or a table with lower and upper", Word => Both, Table => Sides);

read_by_form!(FaceEntry: "\"wall\", \"symmetry\", or a table with wall, velocity, pressure or reservoir", Word => Name, Table => Table);

/// A fluid's material, what drives it, and where it is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct FluidTable {
    /// Density. Required.
    pub density: Option<Density>,
    /// Dynamic viscosity. Required.
    pub viscosity: Option<Viscosity>,
    /// Acceleration that drives the fluid, besides gravity (default: none).
    pub acceleration: Option<[Acceleration; 3]>,
    /// Velocity at the start (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Gauge pressure at the start, without its hydrostatic part (default: zero).
    pub pressure: Option<Pressure>,
    /// Largest speed that is expected; a fluid checks its resolution against it.
    pub expected_speed: Option<Velocity>,
    /// Points in the fluid: there is fluid only where a way leads to one of them (default: wherever
    /// nothing is solid).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inside: Vec<[Length; 3]>,
    /// Points that no way may lead to from those inside: a fluid that reaches one leaks, and is
    /// refused, with the narrowest place of the way and the parts beside it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outside: Vec<[Length; 3]>,
    /// Regions that hold fluid at the start (default: all space that nothing else takes). With them
    /// the fluid has a free surface, above which there is nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fill: Vec<FillTable>,
    /// The law of a gas that is compressed, and what of it is not at rest at the start (default: the
    /// fluid is no gas).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gas: Option<GasTable>,
}

/// A region that holds fluid at the start: what lies in the box, below the level, and inside the
/// part, as far as these are given. At least one of them is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct FillTable {
    /// Lower corner of the box (default: that of the domain).
    pub min: Option<[Length; 3]>,
    /// Upper corner of the box (default: that of the domain).
    pub max: Option<[Length; 3]>,
    /// Height of the level on the axis along which gravity acts.
    pub level: Option<Length>,
    /// Name of the part whose inside holds the fluid.
    pub part: Option<String>,
    /// Velocity there at the start (default: that of the fluid).
    pub velocity: Option<[Velocity; 3]>,
}
