//! A compressible gas: its law, and what of it is not at rest at the start.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What makes a scene's fluid a perfect gas that is compressed. Its density at rest and its
/// viscosity are the fluid's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GasMaterial {
    /// Absolute pressure of the gas at rest [Pa].
    pub pressure: f64,
    /// Temperature of the gas at rest [K]; the viscosity is that at this temperature.
    pub temperature: f64,
    /// Ratio of specific heats.
    pub heat_ratio: f64,
    /// Prandtl's number.
    pub prandtl: f64,
    /// Sutherland's temperature, by which the viscosity grows with the temperature [K].
    pub sutherland: f64,
    /// Temperatures of surfaces by the material of bodies and parts [K]; no heat passes through
    /// other ones.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub surface_temperatures: BTreeMap<String, f64>,
    /// Boxes that hold gas of another state at the start; later ones lie over earlier ones.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<GasRegion>,
    /// A shock that is under way at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shock: Option<Shock>,
    /// A vortex that turns at the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vortex: Option<Vortex>,
}

/// Gas of one state in a box at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GasRegion {
    /// Lower corner [m].
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Density [kg/m³].
    pub density: f64,
    /// Absolute pressure [Pa].
    pub pressure: f64,
    /// Velocity [m/s].
    pub velocity: [f64; 3],
}

impl GasRegion {
    /// True if a point [m] lies in the box, its faces included.
    pub fn holds(&self, point: [f64; 3]) -> bool {
        (0..3).all(|a| self.min[a] <= point[a] && point[a] <= self.max[a])
    }
}

/// A plane shock that runs along an axis into the gas at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shock {
    /// The axis.
    pub axis: usize,
    /// Where on the axis it is at the start [m].
    pub position: f64,
    /// 1 if it runs up the axis, -1 if down.
    pub direction: f64,
    /// Its speed over the speed of sound ahead of it, above 1.
    pub mach: f64,
}

impl Shock {
    /// True if a point [m] is behind it at the start.
    pub fn has_passed(&self, point: [f64; 3]) -> bool {
        (point[self.axis] - self.position) * self.direction < 0.0
    }
}

/// A vortex without change of entropy about an axis: the speed along circles is
/// `speed (r/R) exp((1 - r²/R²)/2)`, the largest of them at the radius R.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vortex {
    /// The axis about which it turns.
    pub axis: usize,
    /// A point of the axis [m].
    pub centre: [f64; 3],
    /// Radius of the fastest circle [m].
    pub radius: f64,
    /// Speed along it, positive if it turns about the axis by the right hand [m/s].
    pub speed: f64,
}
