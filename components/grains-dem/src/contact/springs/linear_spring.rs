//! Linear springs (Cundall and Strack, *Géotechnique* 29, 1979).
//!
//! ```text
//! f_n = k_n delta + gamma_n v_n        gamma_n = 2 zeta sqrt(k_n m*), gamma_t = gamma_n sqrt(k_t/k_n)
//! ```
//!
//! A collision without damping takes `pi sqrt(m*/k_n)`, whatever its speed.

use crate::contact::springs::{Bound, ContactSpring, Dashpots, Reduced, Stiffness};
use core::f64::consts::PI;
use tremie_messages::finding::short;

/// Two stiffnesses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearSpring {
    /// Normal stiffness [N/m].
    pub normal_stiffness: f64,
    /// Tangential stiffness [N/m].
    pub tangential_stiffness: f64,
    /// `1/k_t`, or 0 without a tangential spring [m/N].
    pub inverse_k_t: f64,
}

impl LinearSpring {
    pub fn new(normal_stiffness: f64, tangential_stiffness: f64) -> Self {
        let k_t = tangential_stiffness;
        let inverse_k_t = if k_t > 0.0 { 1.0 / k_t } else { 0.0 };
        Self { normal_stiffness, tangential_stiffness, inverse_k_t }
    }
}

impl ContactSpring for LinearSpring {
    #[inline(always)]
    fn at(&self, overlap: f64, _: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness {
        Stiffness {
            elastic: self.normal_stiffness * overlap,
            gamma_n: dashpots.normal.at(pair.root_mass),
            k_t: self.tangential_stiffness,
            inverse_k_t: self.inverse_k_t,
            gamma_t: dashpots.tangential.at(pair.root_mass),
            remembered: 1.0,
            pull_off: 0.0,
        }
    }

    #[inline(always)]
    fn normal_energy(&self, overlap: f64, _: Reduced) -> f64 {
        0.5 * (self.normal_stiffness * overlap) * overlap
    }

    #[inline(always)]
    fn normal_slope(&self, _: f64, _: Reduced) -> f64 {
        self.normal_stiffness
    }

    #[inline(always)]
    fn as_linear(&self) -> Option<LinearSpring> {
        Some(*self)
    }

    fn dashpots(&self, zeta: f64) -> [f64; 2] {
        let twice = 2.0 * zeta;
        [twice * self.normal_stiffness.sqrt(), twice * self.tangential_stiffness.sqrt()]
    }

    fn critical_dashpot(&self, pair: Reduced) -> f64 {
        2.0 * pair.root_mass * self.normal_stiffness.sqrt()
    }

    fn exponent(&self) -> f64 {
        1.0
    }

    fn overlap_under(&self, force: f64, _: Reduced) -> f64 {
        force / self.normal_stiffness
    }

    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        speed * (pair.root_mass * pair.root_mass / self.normal_stiffness).sqrt()
    }

    fn contact_time(&self, pair: Reduced, _: f64) -> f64 {
        PI * (pair.root_mass * pair.root_mass / self.normal_stiffness).sqrt()
    }

    fn name(&self) -> &'static str {
        "a linear spring"
    }

    fn numbers(&self) -> Vec<(&'static str, f64, Bound)> {
        vec![
            ("normal_stiffness", self.normal_stiffness, Bound::Positive),
            ("tangential_stiffness", self.tangential_stiffness, Bound::NotNegative),
        ]
    }

    fn stiffness_in_words(&self) -> String {
        format!("normal_stiffness {} N/m", short(self.normal_stiffness))
    }

    fn remedy(&self, factor: f64) -> String {
        let (now, then) = (short(self.normal_stiffness), short(self.normal_stiffness * factor));
        format!("a normal_stiffness of {then} N/m (now {now} N/m) makes it")
    }
}
