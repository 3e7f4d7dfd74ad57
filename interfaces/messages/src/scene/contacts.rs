//! Contact laws.

use schemars::JsonSchema;
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
#[serde(rename_all = "snake_case")]
pub enum Spring {
    /// Linear.
    Linear {
        /// Normal stiffness [N/m].
        normal_stiffness: f64,
        /// Tangential stiffness [N/m].
        tangential_stiffness: f64,
    },
    /// A linear one along the normal, and Coulomb's friction without history across it: it opposes
    /// sliding with the full `friction F_n`, as far as a time step bears it.
    LinearNoHistory {
        /// Normal stiffness [N/m].
        normal_stiffness: f64,
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
    /// The springs of Chen et al. (2019), by the mean mass `m = (m_1 + m_2)/2` of a pair, of a body
    /// with a wall or a part the body's: `F_n = k (delta + gap)` with `k = m stiffness_per_mass`,
    /// and `k_t = k/(2 (1 + psi))`. Damping is by [`Damping::Ratio`].
    Chen {
        /// Stiffness over the mean mass, which they take as `g/(theta dx)` [1/s²].
        stiffness_per_mass: f64,
        /// Gap of the surfaces at which contact begins [m].
        gap: f64,
        /// Their number `psi`, in the place of a Poisson's ratio.
        psi: f64,
        /// The tangential spring.
        tangential: Tangential,
    },
}

/// Tangential spring of the law of Chen et al.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tangential {
    /// One that remembers the displacement since the contact began.
    Spring,
    /// As they print it: one that knows the displacement of a single time step `dt`, which makes it
    /// a dashpot `k_t dt`; at rest it carries nothing.
    OneStep,
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
    /// By the damping ratio: the normal dashpot is `2 ratio sqrt(m k_n)`, with the mass that the
    /// law reckons with, the reduced one or under the law of Chen et al. the mean one; the
    /// tangential dashpot is the normal one times `sqrt(k_t/k_n)`.
    Ratio(f64),
}
