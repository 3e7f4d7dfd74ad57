//! The manifest's tables of a gas that is compressed.

use super::AxisName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tremie_messages::units::{Density, Length, Pressure, Temperature, Velocity};

/// A perfect gas. Its density at rest and its viscosity are the fluid's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct GasTable {
    /// Absolute pressure of the gas at rest. Required.
    pub pressure: Option<Pressure>,
    /// Temperature of the gas at rest, at which the viscosity is the fluid's (default: 293.15 K).
    pub temperature: Option<Temperature>,
    /// Ratio of specific heats (default: 1.4, as of air).
    pub heat_ratio: Option<f64>,
    /// Prandtl's number (default: 0.72).
    pub prandtl: Option<f64>,
    /// Sutherland's temperature, by which the viscosity grows with the temperature (default:
    /// 110.4 K, that of air).
    pub sutherland: Option<Temperature>,
    /// Temperatures of surfaces by the material of bodies and parts, `{ steel = "350 K" }`
    /// (default: none; no heat passes through other surfaces).
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub surface_temperatures: BTreeMap<String, Temperature>,
    /// Boxes that hold gas of another state at the start; later ones lie over earlier ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<GasRegionTable>,
    /// A shock that is under way at the start (default: none).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shock: Option<ShockTable>,
    /// A vortex that turns at the start (default: none).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vortex: Option<VortexTable>,
}

/// Gas of one state in a box at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct GasRegionTable {
    /// Lower corner (default: that of the domain).
    pub min: Option<[Length; 3]>,
    /// Upper corner (default: that of the domain).
    pub max: Option<[Length; 3]>,
    /// Density (default: that at rest).
    pub density: Option<Density>,
    /// Absolute pressure (default: that at rest).
    pub pressure: Option<Pressure>,
    /// Velocity (default: that of the fluid).
    pub velocity: Option<[Velocity; 3]>,
}

/// A plane shock that runs along an axis into the gas at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ShockTable {
    /// The axis. Required.
    pub axis: Option<AxisName>,
    /// Where on the axis it is at the start. Required.
    pub position: Option<Length>,
    /// Where it runs (default: up the axis).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<AxisDirection>,
    /// Its speed over the speed of sound ahead of it, above 1. Required.
    pub mach: Option<f64>,
}

/// Up or down an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum AxisDirection {
    /// To larger coordinates.
    #[default]
    Up,
    /// To smaller coordinates.
    Down,
}

/// A vortex without change of entropy about an axis: the speed along circles is
/// `speed (r/R) exp((1 - r²/R²)/2)`, the largest of them at the radius R.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct VortexTable {
    /// The axis about which it turns (default: the one across a plane scene, else z).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<AxisName>,
    /// A point of the axis. Required.
    pub centre: Option<[Length; 3]>,
    /// Radius of the fastest circle. Required.
    pub radius: Option<Length>,
    /// Speed along it, positive if it turns about the axis by the right hand. Required.
    pub speed: Option<Velocity>,
}
