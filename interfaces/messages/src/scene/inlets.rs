//! Inlets and outlets: regions that add grains to a run and remove them.

use super::Diameters;
use serde::{Deserialize, Serialize};

/// A region that is kept filled with spheres, so that they flow on from it at a solid fraction.
///
/// Spheres come at the end of a window, one by one, where they overlap nothing, without spin. While
/// they fall short, the next one waits for a place.
///
/// The fraction is the volume that spheres and region have in common over the region's volume
/// outside of parts. It is a mean over time, and holds from the mean distance on at which spheres
/// come. They come whole, some radii away from where the stream enters, and before that the region
/// holds less. So the stream beyond has the fraction, however long the region is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inlet {
    /// Name, unique among inlets, outlets and probes: letters, digits, `_`.
    pub name: String,
    /// Name of the set of free bodies that they join.
    pub bodies: String,
    /// Lower corner of the region [m]; whole spheres lie inside the region and outside all parts.
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Solid fraction at which they flow on.
    pub fraction: f64,
    /// Their diameters.
    pub diameters: Diameters,
    /// Time between insertions [s], which is rounded up to whole windows; `None`: 50 steps of the
    /// grains.
    #[serde(default)]
    pub every: Option<f64>,
    /// Velocity with which they come.
    pub velocity: InletVelocity,
    /// Time from which on none comes [s].
    #[serde(default)]
    pub until: Option<f64>,
    /// Seed of the random numbers, which are keyed by it, the inlet and the id of the sphere.
    pub seed: u64,
    /// Places that are tried for a sphere, the first half of them next to where spheres come from.
    #[serde(default = "Inlet::default_tries")]
    pub tries: u32,
}

impl Inlet {
    /// Default number of places that are tried for a sphere.
    pub const TRIES: u32 = 200;

    fn default_tries() -> u32 {
        Self::TRIES
    }
}

/// Velocity of spheres that come.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InletVelocity {
    /// Given [m/s].
    Given([f64; 3]),
    /// The mean velocity of the fluid at an open face of the domain, normal to it, as the fluid
    /// told it last ([`crate::PortState`]).
    Face {
        /// The axis: 0, 1, 2 for x, y, z.
        axis: usize,
        /// 0 for the lower face, 1 for the upper.
        side: usize,
    },
}

/// A half space in which no sphere stays: those whose centre lies in it at a window's end are
/// removed.
///
/// An open face of the domain on its side no longer holds spheres back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Outlet {
    /// Name, unique among inlets, outlets and probes: letters, digits, `_`.
    pub name: String,
    /// The axis across which its plane lies: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Position of the plane on the axis [m].
    pub at: f64,
    /// Side of the plane: 0 below, 1 above.
    pub side: usize,
}

impl Outlet {
    /// True if a place [m] lies in the half space.
    pub fn holds(&self, x: [f64; 3]) -> bool {
        if self.side == 0 { x[self.axis] < self.at } else { x[self.axis] > self.at }
    }
}
