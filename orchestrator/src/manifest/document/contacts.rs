//! The manifest's tables of materials and contact laws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::scene::Tangential;
use tremie_messages::units::{Dashpot, Density, Length, Pressure, Stiffness};

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

/// Spring, dashpot and friction. Springs by `normal_stiffness` and `tangential_stiffness`, by
/// `normal_stiffness` and `friction_history = false`, or by `hertz = true`; damping by `restitution`, or by both dashpots. Or both by `chen`.
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
    /// Springs and dashpots of Chen et al. (2019), by the mean mass of a pair and the cell of the
    /// fluid; in place of stiffnesses and damping. It needs gravity.
    pub chen: Option<ChenTable>,
    /// Coefficient of friction (default: 0; with `chen` 0.3).
    pub friction: Option<f64>,
    /// Whether friction has a spring that remembers the sliding since a contact began. Without it
    /// friction opposes sliding by the coefficient times the normal force, and nothing holds at
    /// rest: `tangential_stiffness` is left out then (default: true).
    pub friction_history: Option<bool>,
    /// Coefficient of rolling friction: largest rolling torque over normal force and reduced radius
    /// (default: 0).
    pub rolling_friction: Option<f64>,
    /// Coefficient of restitution, more than 0 and at most 1.
    pub restitution: Option<f64>,
    /// Coefficient of the normal dashpot of a linear spring.
    pub normal_damping: Option<Dashpot>,
    /// Coefficient of the tangential dashpot of a linear spring.
    pub tangential_damping: Option<Dashpot>,
    /// Whether the dashpot may pull before two bodies separate (default: false; with `chen` true).
    pub tension: Option<bool>,
}

/// The law of Chen et al. (2019): the stiffness `k = m g/(theta cell)` by the mean mass m of a
/// pair, or the mass of a body at a wall or a part, and the dashpot `2 alpha sqrt(m k)`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ChenTable {
    /// Cell of the fluid.
    pub cell: Option<Length>,
    /// Gap of the surfaces at which contact begins; they take two cells (default: 0).
    pub gap: Option<Length>,
    /// Overlap under a body's own weight over the cell (default: 0.01).
    pub theta: Option<f64>,
    /// Damping over `2 sqrt(m k)` (default: 0.4).
    pub alpha: Option<f64>,
    /// The tangential spring is `k/(2 (1 + psi))` (default: 0.3).
    pub psi: Option<f64>,
    /// Tangential spring: "spring", which remembers the displacement of the contact, or "one-step",
    /// that of one time step alone, as they print it (default: "spring").
    pub tangential: Option<Tangential>,
}
