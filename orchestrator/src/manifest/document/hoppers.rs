//! The manifest's table of hoppers.

use super::AxisName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Angle, Length};

/// A hopper: two leaning walls that narrow a channel to a slit, through the whole depth of the
/// domain. It becomes the fixed parts `NAME-lower` and `NAME-upper`, by their sides on the axis
/// `across`, and with `rough` a set of fixed bodies, `NAME-rough`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct HopperTable {
    /// Name, unique among the hoppers: letters, digits, `-` and `_`. Required.
    pub name: Option<String>,
    /// Which way the flow goes. Required.
    pub flow: Option<DirectionName>,
    /// The axis along which the walls come together. Required.
    pub across: Option<AxisName>,
    /// Angle of both walls to the section of the channel: to the horizontal, where the flow goes
    /// down. Required.
    pub angle: Option<Angle>,
    /// Width of the slit. Required.
    pub slit: Option<Length>,
    /// Where the slit is, on the axis of the flow. Required.
    pub exit: Option<Length>,
    /// Width of the channel (default: the domain's, less the diameters of rough walls).
    pub width: Option<Length>,
    /// Middle of slit and channel, on the axis `across` (default: the domain's).
    pub centre: Option<Length>,
    /// How far from the slit upstream the walls reach, those of the channel included where it is
    /// narrower than the domain (default: to the domain's end).
    pub height: Option<Length>,
    /// Material of its walls, for contacts (default: the domain's).
    pub material: Option<String>,
    /// Covers the walls of hopper and channel with fixed spheres, in a plane scene with cylinders
    /// (default: smooth walls). Slit, width and angle are those of the planes that touch the
    /// spheres.
    pub rough: Option<RoughTable>,
}

/// Fixed spheres on a wall, side by side in a hexagonal layer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct RoughTable {
    /// Their diameter. Required.
    pub diameter: Option<Length>,
}

/// A way along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub(in super::super) enum DirectionName {
    /// To larger x.
    #[serde(rename = "+x")]
    PlusX,
    /// To smaller x.
    #[serde(rename = "-x")]
    MinusX,
    /// To larger y.
    #[serde(rename = "+y")]
    PlusY,
    /// To smaller y.
    #[serde(rename = "-y")]
    MinusY,
    /// To larger z.
    #[serde(rename = "+z")]
    PlusZ,
    /// To smaller z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl DirectionName {
    /// Number of the axis, and 1 or -1.
    pub fn axis_and_sign(self) -> (usize, f64) {
        match self {
            Self::PlusX => (0, 1.0),
            Self::MinusX => (0, -1.0),
            Self::PlusY => (1, 1.0),
            Self::MinusY => (1, -1.0),
            Self::PlusZ => (2, 1.0),
            Self::MinusZ => (2, -1.0),
        }
    }
}
