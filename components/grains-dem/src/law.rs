//! A contact law in the form that the inner loop wants.

use crate::damping::damping_ratio;
use tremie_messages::scene::{ContactLaw, Damping, Scene, Spring};

/// Linear spring, dashpot and friction, with dashpots as functions of the pair's reduced mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// Normal stiffness [N/m].
    pub k_n: f64,
    /// Tangential stiffness [N/m].
    pub k_t: f64,
    /// `1/k_t`, or 0 without a tangential spring [m/N].
    pub inverse_k_t: f64,
    /// Coefficient of friction.
    pub mu: f64,
    /// Whether the dashpot may pull.
    pub tension: bool,
    gamma_n: Dashpot,
    gamma_t: Dashpot,
}

/// A dashpot's coefficient [kg/s] as `fixed + per_root_mass sqrt(m*)`.
#[derive(Clone, Copy, Debug)]
struct Dashpot {
    fixed: f64,
    per_root_mass: f64,
}

impl Dashpot {
    fn at(self, root_mass: f64) -> f64 {
        self.fixed + self.per_root_mass * root_mass
    }
}

impl Law {
    /// The law of a scene. With a given restitution the damping ratio is the same for all pairs,
    /// so `gamma_n = 2 zeta sqrt(k_n m*)`, and `gamma_t = gamma_n sqrt(k_t/k_n)`.
    pub fn new(law: &ContactLaw) -> Self {
        let (k_n, k_t) = stiffnesses(law);
        let (gamma_n, gamma_t) = match law.damping {
            Damping::Restitution(e) => {
                let twice_zeta = 2.0 * damping_ratio(e, law.tension);
                let scaled = |k: f64| Dashpot { fixed: 0.0, per_root_mass: twice_zeta * k.sqrt() };
                (scaled(k_n), scaled(k_t))
            }
            Damping::Coefficients { normal, tangential } => {
                let constant = |gamma| Dashpot { fixed: gamma, per_root_mass: 0.0 };
                (constant(normal), constant(tangential))
            }
        };
        Self {
            k_n,
            k_t,
            inverse_k_t: if k_t > 0.0 { 1.0 / k_t } else { 0.0 },
            mu: law.friction,
            tension: law.tension,
            gamma_n,
            gamma_t,
        }
    }

    /// A law between bodies that never meet.
    pub fn none() -> Self {
        Self::new(&ContactLaw {
            spring: Spring::Linear { normal_stiffness: 0.0, tangential_stiffness: 0.0 },
            friction: 0.0,
            rolling_friction: 0.0,
            damping: Damping::Coefficients { normal: 0.0, tangential: 0.0 },
            tension: false,
        })
    }

    /// Normal dashpot [kg/s] of a pair with `root_mass = sqrt(m*)`.
    #[inline(always)]
    pub fn gamma_n(&self, root_mass: f64) -> f64 {
        self.gamma_n.at(root_mass)
    }

    /// Tangential dashpot [kg/s] of a pair with `root_mass = sqrt(m*)`.
    #[inline(always)]
    pub fn gamma_t(&self, root_mass: f64) -> f64 {
        self.gamma_t.at(root_mass)
    }
}

/// Normal and tangential stiffness [N/m] of linear springs; others were refused.
pub(crate) fn stiffnesses(law: &ContactLaw) -> (f64, f64) {
    match law.spring {
        Spring::Linear { normal_stiffness, tangential_stiffness } => {
            (normal_stiffness, tangential_stiffness)
        }
        Spring::Hertz { .. } => (0.0, 0.0),
    }
}

/// The laws between two bodies and between a body and a wall: those of the first set.
pub(crate) fn of_scene(scene: &Scene) -> Option<[&ContactLaw; 2]> {
    let body = &scene.bodies.first()?.material;
    let law = scene.law(body, body);
    let wall = scene.law(body, &scene.domain.material);
    Some([law.or(wall)?, wall.or(law)?])
}
