//! The manifest's tables of the scene.

use super::values::DiameterEntry;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::scene::{Face, Motion};
use tremie_messages::units::{
    Acceleration, AngularVelocity, Dashpot, Density, Length, Stiffness, Velocity, Viscosity,
};

/// What is simulated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SceneTable {
    /// Acceleration of gravity (default: none).
    pub gravity: Option<[Acceleration; 3]>,
    /// The box in which everything happens.
    pub domain: DomainTable,
    /// The fluid's material; left out for a dry run.
    pub fluid: Option<FluidTable>,
    /// Walls inside the domain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneTable>,
    /// Bodies, in sets of one material and motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodiesTable>,
    /// Contact laws.
    pub contacts: Option<ContactsTable>,
}

/// The box in which everything happens.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct DomainTable {
    /// Lower corner (default: zero).
    pub origin: Option<[Length; 3]>,
    /// Edge lengths. Required.
    pub size: Option<[Length; 3]>,
    /// What the two faces across x are (default: wall).
    pub x: Option<FaceName>,
    /// What the two faces across y are (default: wall).
    pub y: Option<FaceName>,
    /// What the two faces across z are (default: wall).
    pub z: Option<FaceName>,
}

/// What the two faces of an axis are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum FaceName {
    /// Walls: no slip for the fluid, planes for grains.
    #[default]
    Wall,
    /// Joined to each other.
    Periodic,
}

impl From<FaceName> for Face {
    fn from(name: FaceName) -> Self {
        match name {
            FaceName::Wall => Face::WALL,
            FaceName::Periodic => Face::Periodic,
        }
    }
}

/// A fluid's material and what drives it.
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
    /// Largest speed that is expected; a fluid checks its resolution against it.
    pub expected_speed: Option<Velocity>,
}

/// A plane wall.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PlaneTable {
    /// A point on the plane. Required.
    pub point: Option<[Length; 3]>,
    /// Direction into the space of the bodies, of any length but zero. Required.
    pub normal: Option<[f64; 3]>,
}

/// Bodies of one material and one kind of motion. Exactly one of `spheres` and `packing`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct BodiesTable {
    /// Name, unique in the scene. Required.
    pub name: Option<String>,
    /// Density. Required.
    pub density: Option<Density>,
    /// How they move (default: free).
    pub motion: Option<MotionName>,
    /// Each sphere given.
    pub spheres: Option<Vec<SphereTable>>,
    /// Spheres packed at random, without overlap.
    pub packing: Option<PackingTable>,
}

/// How bodies move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(in super::super) enum MotionName {
    /// Under forces.
    #[default]
    Free,
    /// Never.
    Fixed,
    /// With the velocity that they were placed with, whatever the forces.
    Prescribed,
}

impl From<MotionName> for Motion {
    fn from(name: MotionName) -> Self {
        match name {
            MotionName::Free => Motion::Free,
            MotionName::Fixed => Motion::Fixed,
            MotionName::Prescribed => Motion::Prescribed(Vec::new()),
        }
    }
}

/// A sphere at the start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SphereTable {
    /// Centre. Required.
    pub position: Option<[Length; 3]>,
    /// Diameter. Required.
    pub diameter: Option<Length>,
    /// Velocity (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
}

/// A random packing. Exactly one of `diameter` and `diameters`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PackingTable {
    /// Lower corner of the region; whole spheres lie inside. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner of the region. Required.
    pub max: Option<[Length; 3]>,
    /// Volume of the spheres over volume of the region. Required.
    pub fraction: Option<f64>,
    /// One diameter for all, or `[smallest, largest]` of a uniform distribution.
    pub diameter: Option<DiameterEntry>,
    /// Diameters to draw from, each equally likely.
    pub diameters: Option<Vec<Length>>,
    /// Seed of the random numbers (default: the run's).
    pub seed: Option<u64>,
}

/// Contact laws.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ContactsTable {
    /// Between two bodies. Required.
    pub body_body: Option<ContactTable>,
    /// Between a body and a wall (default: as between two bodies).
    pub body_wall: Option<ContactTable>,
}

/// Linear spring, dashpot and friction. Damping by `restitution`, or by both dashpots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ContactTable {
    /// Normal stiffness. Required.
    pub normal_stiffness: Option<Stiffness>,
    /// Tangential stiffness. Required.
    pub tangential_stiffness: Option<Stiffness>,
    /// Coefficient of friction (default: 0).
    pub friction: Option<f64>,
    /// Coefficient of restitution, more than 0 and at most 1.
    pub restitution: Option<f64>,
    /// Coefficient of the normal dashpot.
    pub normal_damping: Option<Dashpot>,
    /// Coefficient of the tangential dashpot.
    pub tangential_damping: Option<Dashpot>,
    /// Whether the dashpot may pull before two bodies separate (default: false).
    pub tension: Option<bool>,
}
