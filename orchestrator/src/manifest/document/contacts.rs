//! The manifest's tables of materials and contact laws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Dashpot, Density, Pressure, Stiffness};

/// A material of bodies, parts or walls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct MaterialTable {
    /// Density; needed by sets of bodies that give none themselves.
    pub density: Option<Density>,
    /// Young's modulus; needed by laws with `hertz = true`.
    pub youngs_modulus: Option<Pressure>,
    /// Poisson's ratio, more than -1 and at most 0.5; needed by laws with `hertz = true`.
    pub poisson_ratio: Option<f64>,
}

/// Spring, dashpot and friction. Springs by `normal_stiffness` and `tangential_stiffness`, or by
/// `hertz = true`; damping by `restitution`, or by both dashpots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ContactTable {
    /// The two materials, in any order (default: all pairs that no other entry names).
    pub between: Option<[String; 2]>,
    /// Normal stiffness of a linear spring.
    pub normal_stiffness: Option<Stiffness>,
    /// Tangential stiffness of a linear spring.
    pub tangential_stiffness: Option<Stiffness>,
    /// Whether the springs are those of Hertz and Mindlin, from the moduli of the materials
    /// (default: false).
    pub hertz: Option<bool>,
    /// Work of adhesion of a law with `hertz = true`: what parting a unit of area takes, twice the
    /// surface energy of bodies of one material; 1 N/m is 1 J/m2. The law is then that of Johnson,
    /// Kendall and Roberts (default: no adhesion).
    pub work_of_adhesion: Option<Stiffness>,
    /// Coefficient of friction (default: 0).
    pub friction: Option<f64>,
    /// Coefficient of rolling friction: largest rolling torque over normal force and reduced radius
    /// (default: 0).
    pub rolling_friction: Option<f64>,
    /// Coefficient of restitution, more than 0 and at most 1.
    pub restitution: Option<f64>,
    /// Coefficient of the normal dashpot of a linear spring.
    pub normal_damping: Option<Dashpot>,
    /// Coefficient of the tangential dashpot of a linear spring.
    pub tangential_damping: Option<Dashpot>,
    /// Whether the dashpot may pull before two bodies separate (default: false).
    pub tension: Option<bool>,
}
