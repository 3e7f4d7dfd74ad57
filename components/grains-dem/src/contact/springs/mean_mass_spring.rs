//! Springs by the mean mass of a pair (Chen, Zhang, Zang & Ning, *J. Fluids Struct.* 91, 2019,
//! 102772, Eqs. 7-19, which they write for discs).
//!
//! ```text
//! f_n = k (delta + gap) + c v_n        k = m g/(theta dx)      c = 2 alpha sqrt(m k)
//! k_t = k/(2 (1 + psi))                                        c_t = c/sqrt(2 (1 + psi))
//! ```
//!
//! with m the mean of both masses, or of a body with a wall or a part the body's own, and contact
//! as soon as `delta + gap > 0`. All of them come from `kappa = g/(theta dx)`: `k = kappa m` and `c
//! = 2 alpha sqrt(kappa) m`. The mean mass is not what moves against the spring: that is the
//! reduced mass m*, so that the damping ratio of a collision is `alpha sqrt(m/m*)`, of equal bodies
//! `sqrt(2) alpha`, and the duration of one without damping is `pi sqrt(m*/(kappa m))`, which a
//! light body against a heavy one makes short.
//!
//! They print no spring of the tangential force that lasts: `f_t = -(k_t v_t dt + c_t v_t)`, a
//! dashpot that depends on the time step dt of the bodies.

use crate::contact::springs::{Bound, ContactSpring, Dashpots, Reduced, Stiffness};
use core::f64::consts::PI;
use tremie_messages::finding::short;
use tremie_messages::scene::Tangential;

/// The numbers of the law; see [`tremie_messages::scene::Spring::Chen`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeanMassSpring {
    /// Stiffness over the mean mass [1/s²].
    kappa: f64,
    /// Gap at which contact begins [m].
    gap: f64,
    psi: f64,
    tangential: Tangential,
    /// `k_t/k`.
    across: f64,
    /// The step that the displacement of a one-step spring is of [s]; 0 before there is a run.
    step: f64,
}

impl MeanMassSpring {
    pub fn new(kappa: f64, gap: f64, psi: f64, tangential: Tangential) -> Self {
        Self { kappa, gap, psi, tangential, across: 0.5 / (1.0 + psi), step: 0.0 }
    }

    /// The law in a run with steps of a length [s].
    pub fn in_steps(self, step: f64) -> Self {
        Self { step, ..self }
    }

    /// Normal stiffness [N/m].
    #[inline(always)]
    fn stiffness(&self, pair: Reduced) -> f64 {
        self.kappa * pair.mean_mass
    }
}

impl ContactSpring for MeanMassSpring {
    #[inline(always)]
    fn at(&self, overlap: f64, _: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness {
        let k = self.stiffness(pair);
        let k_t = self.across * k;
        let gamma_t = dashpots.tangential.at(pair.mean_mass);
        let (k_t, gamma_t) = match self.tangential {
            Tangential::Spring => (k_t, gamma_t),
            Tangential::OneStep => (0.0, k_t * self.step + gamma_t),
        };
        Stiffness {
            elastic: k * (overlap + self.gap),
            gamma_n: dashpots.normal.at(pair.mean_mass),
            k_t,
            inverse_k_t: if k_t > 0.0 { 1.0 / k_t } else { 0.0 },
            gamma_t,
            remembered: 1.0,
            pull_off: 0.0,
        }
    }

    #[inline(always)]
    fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        let depth = (overlap + self.gap).max(0.0);
        0.5 * (self.stiffness(pair) * depth) * depth
    }

    #[inline(always)]
    fn normal_slope(&self, _: f64, pair: Reduced) -> f64 {
        self.stiffness(pair)
    }

    #[inline(always)]
    fn gap(&self) -> f64 {
        self.gap
    }

    fn one_step_stiffness(&self, pair: Reduced) -> f64 {
        match self.tangential {
            Tangential::Spring => 0.0,
            Tangential::OneStep => self.across * self.stiffness(pair),
        }
    }

    fn is_by_mean_mass(&self) -> bool {
        true
    }

    fn is_for_rigid_spheres(&self) -> bool {
        true
    }

    fn dashpots(&self, alpha: f64) -> [f64; 2] {
        let normal = 2.0 * alpha * self.kappa.sqrt();
        [normal, normal * self.across.sqrt()]
    }

    fn critical_dashpot(&self, pair: Reduced) -> f64 {
        2.0 * pair.root_mass * self.stiffness(pair).sqrt()
    }

    fn takes_restitution(&self) -> bool {
        false
    }

    fn exponent(&self) -> f64 {
        1.0
    }

    /// With a gap less than 0 under small forces.
    fn overlap_under(&self, force: f64, pair: Reduced) -> f64 {
        force / self.stiffness(pair) - self.gap
    }

    /// With a gap less than 0 at low speeds.
    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        speed * pair.root_mass / self.stiffness(pair).sqrt() - self.gap
    }

    fn contact_time(&self, pair: Reduced, _: f64) -> f64 {
        PI * pair.root_mass / self.stiffness(pair).sqrt()
    }

    fn name(&self) -> &'static str {
        "the law of Chen et al."
    }

    fn numbers(&self) -> Vec<(&'static str, f64, Bound)> {
        vec![
            ("stiffness_per_mass", self.kappa, Bound::Positive),
            ("gap", self.gap, Bound::NotNegative),
            ("psi", self.psi, Bound::NotNegative),
        ]
    }

    fn stiffness_in_words(&self) -> String {
        format!("{} N/m for each kilogram of the mean mass", short(self.kappa))
    }

    fn remedy(&self, factor: f64) -> String {
        format!("a theta or a cell {} times smaller makes it", short(factor))
    }
}
