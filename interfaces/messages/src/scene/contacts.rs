//! Contact laws.

use serde::{Deserialize, Serialize};

/// The contact law between two materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PairLaw {
    /// The materials; twice the same for contacts of a material with itself.
    pub between: [String; 2],
    /// The law.
    pub law: ContactLaw,
}

/// Spring, dashpot, friction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactLaw {
    /// The springs.
    pub spring: Spring,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of rolling friction: largest rolling torque over normal force and reduced
    /// radius. 0 for none.
    pub rolling_friction: f64,
    /// Damping.
    pub damping: Damping,
    /// The dashpot may pull before two bodies separate. Most papers print this form.
    pub tension: bool,
}

/// Springs of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Spring {
    /// Linear.
    Linear {
        /// Normal stiffness [N/m].
        normal_stiffness: f64,
        /// Tangential stiffness [N/m].
        tangential_stiffness: f64,
    },
    /// Hertz's normal force, `F_n = 4/3 E* sqrt(R*) delta^(3/2)`, and Mindlin's tangential
    /// stiffness without slip, `k_t = 8 G* sqrt(R* delta)`. The bodies have the reduced radius `R*`
    /// and overlap by `delta`.
    Hertz {
        /// Effective Young's modulus `E*`, `1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2` [Pa].
        effective_modulus: f64,
        /// Effective shear modulus `G*`, `1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2` [Pa].
        effective_shear_modulus: f64,
    },
    /// Hertz's contact with the adhesion of Johnson, Kendall and Roberts (1971): bodies that
    /// touched hold on until they are pulled apart, by `3/2 pi w R*` at most.
    Jkr {
        /// As for [`Hertz`](Self::Hertz) [Pa].
        effective_modulus: f64,
        /// As for [`Hertz`](Self::Hertz) [Pa].
        effective_shear_modulus: f64,
        /// Work of adhesion w: what parting a unit of area takes, twice the surface energy of
        /// bodies of one material [J/m²].
        work_of_adhesion: f64,
    },
}

/// Damping of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Damping {
    /// By the coefficient of restitution; the dashpot then depends on the masses of the pair, and
    /// the tangential one is the normal one times `sqrt(k_t/k_n)`.
    Restitution(f64),
    /// By the dashpots' coefficients [kg/s]; for linear springs.
    Coefficients {
        /// Normal.
        normal: f64,
        /// Tangential.
        tangential: f64,
    },
}
