//! A linear normal spring, and Coulomb's friction without history (Goetsch 2015, who calls it
//! static friction; `F_t = -mu f_n v_t/|v_t|`).
//!
//! ```text
//! f_n = k_n delta + gamma_n v_n
//! F_t = -min(mu f_n, gamma_t |v_t|) v_t/|v_t|        gamma_t = (1/4) (2/7) m*/dt
//! ```
//!
//! As printed the force jumps where `v_t` changes its sign, and a step of length dt would throw a
//! contact at rest to and fro. So it is at most a dashpot, the strongest that many contacts of one
//! sphere bear: a contact of two spheres, whose sliding has the mass `2/7 m*`, loses a quarter of
//! its sliding in a step. Nothing is remembered, so that a slope at rest creeps: a sphere by `14
//! (m/m*) g dt`.

use crate::contact::springs::linear_spring::LinearSpring;
use crate::contact::springs::{Bound, ContactSpring, Dashpots, Reduced, Stiffness};
use tremie_messages::finding::short;

/// Part of its sliding that a contact of two spheres loses in a step, if friction allows.
const STOPPED: f64 = 0.25;
/// Mass of the sliding of two spheres that may turn, over their reduced mass.
const SLIDING: f64 = 2.0 / 7.0;

/// The normal spring, and the step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearNoHistory {
    normal: LinearSpring,
    /// Tangential dashpot over the reduced mass [1/s]; 0 before there is a run.
    rate: f64,
}

impl LinearNoHistory {
    pub fn new(normal_stiffness: f64) -> Self {
        Self { normal: LinearSpring::new(normal_stiffness, 0.0), rate: 0.0 }
    }

    /// The law in a run with steps of a length [s].
    pub fn in_steps(self, step: f64) -> Self {
        Self { rate: STOPPED * SLIDING / step, ..self }
    }
}

impl ContactSpring for LinearNoHistory {
    #[inline(always)]
    fn at(&self, overlap: f64, before: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness {
        let gamma_t = self.rate * (pair.root_mass * pair.root_mass);
        Stiffness { gamma_t, ..self.normal.at(overlap, before, pair, dashpots) }
    }

    #[inline(always)]
    fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        self.normal.normal_energy(overlap, pair)
    }

    #[inline(always)]
    fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64 {
        self.normal.normal_slope(overlap, pair)
    }

    fn is_for_rigid_spheres(&self) -> bool {
        true
    }

    fn dashpots(&self, zeta: f64) -> [f64; 2] {
        self.normal.dashpots(zeta)
    }

    fn critical_dashpot(&self, pair: Reduced) -> f64 {
        self.normal.critical_dashpot(pair)
    }

    fn exponent(&self) -> f64 {
        self.normal.exponent()
    }

    fn overlap_under(&self, force: f64, pair: Reduced) -> f64 {
        self.normal.overlap_under(force, pair)
    }

    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        self.normal.largest_overlap(pair, speed)
    }

    fn contact_time(&self, pair: Reduced, speed: f64) -> f64 {
        self.normal.contact_time(pair, speed)
    }

    fn name(&self) -> &'static str {
        "a linear spring with friction without history"
    }

    fn numbers(&self) -> Vec<(&'static str, f64, Bound)> {
        vec![("normal_stiffness", self.normal.normal_stiffness, Bound::Positive)]
    }

    fn stiffness_in_words(&self) -> String {
        format!("normal_stiffness {} N/m", short(self.normal.normal_stiffness))
    }

    fn remedy(&self, factor: f64) -> String {
        self.normal.remedy(factor)
    }
}
