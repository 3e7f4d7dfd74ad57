//! The springs of a contact: the trait that a contact law implements, and the laws there are.
//!
//! Everything else asks a law through [`ContactSpring`]; which laws exist is said in this file
//! alone, and ARCHITECTURE.md says how one is added.

pub mod hertz_jkr;
pub mod hertz_mindlin;
pub mod linear_no_history;
pub mod linear_spring;
pub mod mean_mass_spring;

use crate::contact::springs::hertz_jkr::HertzJkr;
use crate::contact::springs::hertz_mindlin::HertzMindlin;
use crate::contact::springs::linear_no_history::LinearNoHistory;
use crate::contact::springs::linear_spring::LinearSpring;
use crate::contact::springs::mean_mass_spring::MeanMassSpring;
use serde::{Deserialize, Serialize};
use tremie_messages::scene::Spring;

/// Masses and size of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C)]
pub(crate) struct Reduced {
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: f64,
    /// `R*` [m].
    pub radius: f64,
    /// Mean of both masses; of a body with a wall, a part or a body of given motion its own [kg].
    pub mean_mass: f64,
}

impl Reduced {
    /// Of a pair that is not there yet.
    pub const NONE: Self = Self { root_mass: 0.0, radius: 0.0, mean_mass: 0.0 };
}

/// Springs and dashpots of a contact at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stiffness {
    /// Elastic normal force [N].
    pub elastic: f64,
    /// Normal dashpot [kg/s].
    pub gamma_n: f64,
    /// Tangential spring [N/m].
    pub k_t: f64,
    /// `1/k_t`, or 0 without a spring [m/N].
    pub inverse_k_t: f64,
    /// Tangential dashpot [kg/s].
    pub gamma_t: f64,
    /// Factor on remembered tangential displacements since the overlap before.
    pub remembered: f64,
    /// Largest pull of a contact that adheres [N].
    pub pull_off: f64,
}

/// A dashpot's coefficient [kg/s] as `fixed + per_root_mass sqrt(m*)`; under Hertz's law as `fixed
/// + per_root_mass sqrt(m* k_H) delta^(1/4)`, and under the law of Chen et al. the mean mass in the
/// place of `sqrt(m*)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dashpot {
    pub fixed: f64,
    pub per_root_mass: f64,
}

impl Dashpot {
    /// The coefficient where what stands for `sqrt(m*)` has a value.
    #[inline(always)]
    pub fn at(self, root_mass: f64) -> f64 {
        self.fixed + self.per_root_mass * root_mass
    }
}

/// Both dashpots of a law.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dashpots {
    pub normal: Dashpot,
    pub tangential: Dashpot,
}

/// Bound of a number of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bound {
    Positive,
    NotNegative,
}

/// Normal and tangential springs of a contact law.
///
/// Forces, energies, slopes and weights are asked in every step, the others before a run.
pub(crate) trait ContactSpring {
    /// Springs and dashpots at an overlap, after `before` at the last evaluation [m].
    fn at(&self, overlap: f64, before: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness;

    /// Work of the elastic normal force since the overlap was 0 [J].
    fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64;

    /// Slope of the elastic normal force over the overlap [N/m].
    fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64;

    /// Length of the neck: largest gap of bodies that touched before their contact ends [m]. It
    /// grows with `R*`.
    #[inline(always)]
    fn neck(&self, _: Reduced) -> f64 {
        0.0
    }

    /// Gap of the surfaces at which contact begins, whether they touched before or not [m].
    #[inline(always)]
    fn gap(&self) -> f64 {
        0.0
    }

    /// Tangential stiffness that acts as a dashpot, `k_t dt` [N/m].
    fn one_step_stiffness(&self, _: Reduced) -> f64 {
        0.0
    }

    /// True if the stiffness goes with the mean mass.
    fn is_by_mean_mass(&self) -> bool {
        false
    }

    /// True if the law has no form for surfaces that deform and for rolling friction.
    fn is_for_rigid_spheres(&self) -> bool {
        false
    }

    /// Weight of a contact in a region of contacts, see [`crate::contact::region_shares`]: the
    /// square root of twice its energy, nothing where it does not touch.
    #[inline(always)]
    fn normal_root(&self, overlap: f64, pair: Reduced) -> f64 {
        // Written so that without a gap the least overlap is 0 and not -0.
        (2.0 * self.normal_energy(overlap.max(0.0 - self.gap()), pair)).sqrt()
    }

    /// The law as a linear spring, if it is one: of others there is no form side by side in
    /// registers, and none for polyhedra, which need `k_n` and `k_t` per area.
    #[inline(always)]
    fn as_linear(&self) -> Option<LinearSpring> {
        None
    }

    /// Normal and tangential [`Dashpot::per_root_mass`] for a damping ratio.
    fn dashpots(&self, zeta: f64) -> [f64; 2];

    /// Normal dashpot of damping ratio 1 at an overlap of 1 m [kg/s].
    fn critical_dashpot(&self, pair: Reduced) -> f64;

    /// True if dashpots may be given by fixed coefficients.
    fn takes_coefficients(&self) -> bool {
        self.as_linear().is_some()
    }

    /// True if dashpots may be given by the restitution.
    fn takes_restitution(&self) -> bool {
        true
    }

    /// The power of the overlap to which the elastic force goes.
    fn exponent(&self) -> f64;

    /// Overlap under a force at rest [m].
    fn overlap_under(&self, force: f64, pair: Reduced) -> f64;

    /// Largest overlap of an undamped head-on collision at a relative speed [m].
    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64;

    /// Duration of a collision without damping at a relative speed [s].
    fn contact_time(&self, pair: Reduced, speed: f64) -> f64;

    /// Name in messages to the user.
    fn name(&self) -> &'static str;

    /// Numbers of the law with their keys in the scene.
    fn numbers(&self) -> Vec<(&'static str, f64, Bound)>;

    /// The stiffness, in words, with its value and unit.
    fn stiffness_in_words(&self) -> String;

    /// Advice that makes overlaps small, where the law's stiffness has to be larger by a factor:
    /// the beginning of a sentence, up to "makes it".
    fn remedy(&self, factor: f64) -> String;
}

/// The laws there are.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RegisteredSpring {
    Linear(LinearSpring),
    LinearNoHistory(LinearNoHistory),
    Hertz(HertzMindlin),
    Jkr(HertzJkr),
    Chen(MeanMassSpring),
}

/// Asks whichever law it is; each is compiled by itself.
macro_rules! ask {
    ($any:expr, $law:ident => $answer:expr) => {
        match $any {
            RegisteredSpring::Linear($law) => $answer,
            RegisteredSpring::LinearNoHistory($law) => $answer,
            RegisteredSpring::Hertz($law) => $answer,
            RegisteredSpring::Jkr($law) => $answer,
            RegisteredSpring::Chen($law) => $answer,
        }
    };
}
pub(crate) use ask;

impl RegisteredSpring {
    /// Spring of a scene.
    pub fn of(spring: &Spring) -> Self {
        match *spring {
            Spring::Linear { normal_stiffness, tangential_stiffness } => {
                Self::Linear(LinearSpring::new(normal_stiffness, tangential_stiffness))
            }
            Spring::LinearNoHistory { normal_stiffness } => {
                Self::LinearNoHistory(LinearNoHistory::new(normal_stiffness))
            }
            Spring::Hertz { effective_modulus, effective_shear_modulus } => {
                Self::Hertz(HertzMindlin { effective_modulus, effective_shear_modulus })
            }
            Spring::Jkr { effective_modulus, effective_shear_modulus, work_of_adhesion } => {
                Self::Jkr(HertzJkr { effective_modulus, effective_shear_modulus, work_of_adhesion })
            }
            Spring::Chen { stiffness_per_mass, gap, psi, tangential } => {
                Self::Chen(MeanMassSpring::new(stiffness_per_mass, gap, psi, tangential))
            }
        }
    }

    /// The law in a run with steps of a length [s].
    pub fn in_steps(self, step: f64) -> Self {
        match self {
            Self::Chen(spring) => Self::Chen(spring.in_steps(step)),
            Self::LinearNoHistory(spring) => Self::LinearNoHistory(spring.in_steps(step)),
            other => other,
        }
    }

    /// The law behind its trait, for questions that are not asked in a step.
    pub fn law(&self) -> &dyn ContactSpring {
        ask!(self, law => law)
    }
}
