//! The manifest's tables of inlets and outlets.

use super::forms::read_by_form;
use super::values::DiameterEntry;
use super::{AxisName, DiametersEntry};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Density, Length, Time, Velocity};

/// A region that is kept filled with spheres, which come during the run. Exactly one of `diameter`
/// and `diameters`; either `bodies`, or a density or a material of its own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct InletTable {
    /// Name, unique among inlets, outlets and probes: letters, digits, `_`. Required.
    pub name: Option<String>,
    /// The set of free bodies that the spheres join (default: one of the inlet's own name).
    pub bodies: Option<String>,
    /// Density of a set of its own (default: the material's).
    pub density: Option<Density>,
    /// Material of a set of its own, one of `[scene.materials]` (default: one of the inlet's own
    /// name).
    pub material: Option<String>,
    /// Lower corner of the region; whole spheres lie inside, and outside of parts. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner of the region. Required.
    pub max: Option<[Length; 3]>,
    /// Solid fraction at which the spheres flow on, in the mean over time: that of the region
    /// outside of parts from where they come on. Required.
    pub fraction: Option<f64>,
    /// One diameter for all, or `[smallest, largest]` of a uniform distribution.
    pub diameter: Option<DiameterEntry>,
    /// Diameters to draw from, each equally likely, or a distribution.
    pub diameters: Option<DiametersEntry>,
    /// Time between insertions, rounded up to whole windows (default: 50 steps of the grains).
    pub every: Option<Time>,
    /// Velocity with which spheres come: a vector, or `{ face = "z_lower" }` for the mean velocity
    /// of the fluid at an open face. Required.
    pub velocity: Option<InletVelocityEntry>,
    /// Time from which on none comes (default: never).
    pub until: Option<Time>,
    /// Seed of the random numbers (default: the run's).
    pub seed: Option<u64>,
    /// Places that are tried for a sphere, the first half of them next to where spheres come from
    /// (default: 200).
    pub tries: Option<u32>,
}

/// Velocity of spheres that come.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub(in super::super) enum InletVelocityEntry {
    /// Given.
    Given([Velocity; 3]),
    /// That of the fluid at a face.
    Fluid(FluidVelocityTable),
}

/// The mean velocity of the fluid at a face of the domain.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct FluidVelocityTable {
    /// The face. Required.
    pub face: Option<FaceOfDomain>,
}

read_by_form!(InletVelocityEntry: "three velocities, or a table with face", List => Given, Table => Fluid);

/// A face of the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(in super::super) enum FaceOfDomain {
    /// At the lower end of x.
    XLower,
    /// At the upper end of x.
    XUpper,
    /// At the lower end of y.
    YLower,
    /// At the upper end of y.
    YUpper,
    /// At the lower end of z.
    ZLower,
    /// At the upper end of z.
    ZUpper,
}

impl FaceOfDomain {
    /// Its axis, and 0 for the lower face, 1 for the upper.
    pub fn axis_and_side(self) -> (usize, usize) {
        match self {
            Self::XLower => (0, 0),
            Self::XUpper => (0, 1),
            Self::YLower => (1, 0),
            Self::YUpper => (1, 1),
            Self::ZLower => (2, 0),
            Self::ZUpper => (2, 1),
        }
    }
}

/// Where spheres leave the run. Open faces that lie in it do not hold them back.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct OutletTable {
    /// Name, unique among inlets, outlets and probes: letters, digits, `_`. Required.
    pub name: Option<String>,
    /// The half space in which none stays. Required.
    pub beyond: Option<BeyondTable>,
}

/// A half space: either `face`, or `axis`, `at` and `side`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct BeyondTable {
    /// What lies beyond a face of the domain.
    pub face: Option<FaceOfDomain>,
    /// The axis across which its plane lies.
    pub axis: Option<AxisName>,
    /// Where on the axis.
    pub at: Option<Length>,
    /// Which side of the plane.
    pub side: Option<SideName>,
}

/// A side of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum SideName {
    /// Below.
    Lower,
    /// Above.
    Upper,
}
