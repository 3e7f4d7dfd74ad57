//! The manifest's tables of parts that slide on an axis.

use super::bodies::MotionName;
use super::forms::{Form, Never, read, read_by_form};
use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize, de};
use tremie_messages::units::{Force, Length, Mass, Stiffness, Velocity};

/// How a part moves: fixed, prescribed, or a table that says under which forces.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum PartMotionEntry {
    /// By name.
    Name(MotionName),
    /// Under forces.
    Table(PartMotionTable),
}

read_by_form!(PartMotionEntry: "\"fixed\", \"prescribed\", or a table with slider", Word => Name, Table => Table);

impl PartMotionEntry {
    /// Whether somebody must move the part.
    pub fn moves(&self) -> bool {
        matches!(self, Self::Table(_) | Self::Name(MotionName::Prescribed))
    }
}

/// A motion under forces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PartMotionTable {
    /// Along one axis, on a spring, between stops.
    pub slider: Option<Box<SliderTable>>,
}

/// A part that moves along one axis under forces. The part's position is where it is at lift 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SliderTable {
    /// Direction of growing lift, of any length but zero. Required.
    pub axis: Option<[f64; 3]>,
    /// Mass of all that moves; of a part that symmetry planes cut, that of the whole. Required.
    pub mass: Option<Mass>,
    /// Lift at the start (default: 0).
    pub lift: Option<Length>,
    /// Velocity at the start, along the axis (default: at rest).
    pub velocity: Option<Velocity>,
    /// Spring, whose force is against the axis (default: none).
    pub spring: Option<SliderSpringTable>,
    /// Constant force along the axis, besides the weight (default: none).
    pub force: Option<Force>,
    /// What bounds the travel (default: nothing).
    pub stops: Option<StopsTable>,
}

/// A spring: `rate` and `preload` make it linear, `stroke` besides makes it stiffen as a tangent up
/// to that lift; or a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SliderSpringTable {
    /// Stiffness at lift 0.
    pub rate: Option<Stiffness>,
    /// Force at lift 0, or the length by which the spring is compressed there (default: none).
    pub preload: Option<PreloadEntry>,
    /// Lift at which no travel is left: the force is `preload + rate (2 a/pi) tan(pi y/(2 a))`.
    pub stroke: Option<Length>,
    /// Force by lift, linear between points: `[["0 mm", "50 N"], ["4 mm", "60 N"]]`.
    pub table: Option<Vec<(Length, Force)>>,
}

/// A force, or a length times the spring's rate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum PreloadEntry {
    /// A force.
    Force(Force),
    /// A length.
    Length(Length),
}

impl<'de> Deserialize<'de> for PreloadEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "a force or a length with a unit, as \"57.5 N\" or \"92 mm\"";
        let form: Form<String, Never, Never> = read(deserializer, EXPECTED)?;
        match form {
            Form::Word(text) => {
                let length = || text.parse().map(Self::Length);
                text.parse().map(Self::Force).or_else(|_| length()).map_err(|_| {
                    de::Error::custom(format_args!("found \"{text}\", expected {EXPECTED}"))
                })
            }
            Form::List(never) | Form::Table(never) => match never {},
        }
    }
}

/// Ends of the travel, each a contact with a linear spring and a dashpot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct StopsTable {
    /// Lift at which the lower one touches (default: there is none).
    pub lower: Option<Length>,
    /// Lift at which the upper one touches (default: there is none).
    pub upper: Option<Length>,
    /// Stiffness. Required.
    pub stiffness: Option<Stiffness>,
    /// Coefficient of restitution, in (0, 1]. Required.
    pub restitution: Option<f64>,
}
