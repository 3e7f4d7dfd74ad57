//! Hertz's normal force with Mindlin's tangential stiffness without slip.
//!
//! With `k_H = 4/3 E* sqrt(R*)`,
//!
//! ```text
//! f_n = k_H delta^(3/2) + gamma_n v_n        gamma_n = sqrt(5) zeta sqrt(k_H m*) delta^(1/4)
//! k_t = 8 G* sqrt(R* delta)                  gamma_t = gamma_n sqrt(k_t/k_n),  k_n = 2 E* sqrt(R* delta)
//! ```
//!
//! In terms of `q = sqrt(4/5 k_H/m*) delta^(5/4)` and the phase `ds = sqrt(5/4 k_H/m*) delta^(1/4)
//! dt` a collision under this dashpot is that of a linear spring with damping ratio `zeta`, speed
//! by speed: `dq/ds = v`, `dv/ds = -q - 2 zeta v` (Antypov & Elliott, *EPL* 94, 2011, whose alpha
//! is `sqrt(5) zeta`; the form of the dashpot is that of Tsuji, Tanaka & Ishida, *Powder Technol.*
//! 71, 1992). So the restitution does not depend on the speed, and damping ratio and restitution go
//! together as for linear springs, with and without tension.

use crate::contact::springs::{Bound, ContactSpring, Dashpots, Reduced, Stiffness};
use tremie_messages::finding::short;

/// Two moduli of a pair of materials; see [`tremie_messages::scene::Spring::Hertz`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct HertzMindlin {
    /// Effective Young's modulus [Pa].
    pub effective_modulus: f64,
    /// Effective shear modulus [Pa].
    pub effective_shear_modulus: f64,
}

impl HertzMindlin {
    /// `k_H = 4/3 E* sqrt(R*)` [N/m^(3/2)].
    fn stiffness(&self, pair: Reduced) -> f64 {
        4.0 / 3.0 * self.effective_modulus * pair.radius.sqrt()
    }
}

impl ContactSpring for HertzMindlin {
    /// Under Mindlin's law the tangential force of a growing overlap does not grow with the spring,
    /// so the remembered displacement shrinks; that of a falling one falls with it, so the
    /// displacement stays (Thornton, Cummins & Cleary, *Powder Technol.* 233, 2013; what LAMMPS
    /// calls `mindlin_rescale/force`). Otherwise the spring would make energy.
    #[inline(always)]
    fn at(&self, overlap: f64, before: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness {
        let contact_radius = (pair.radius * overlap).sqrt();
        let hertz = 4.0 / 3.0 * self.effective_modulus * contact_radius;
        // sqrt(m* k_H) delta^(1/4) = sqrt(m* k_H sqrt(delta)), and hertz = k_H sqrt(delta).
        let damping = pair.root_mass * hertz.sqrt();
        let k_t = 8.0 * self.effective_shear_modulus * contact_radius;
        Stiffness {
            elastic: hertz * overlap,
            gamma_n: dashpots.normal.at(damping),
            k_t,
            inverse_k_t: if k_t > 0.0 { 1.0 / k_t } else { 0.0 },
            gamma_t: dashpots.tangential.at(damping),
            remembered: if before < overlap { (before / overlap).sqrt() } else { 1.0 },
            pull_off: 0.0,
        }
    }

    #[inline(always)]
    fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        let contact_radius = (pair.radius * overlap).sqrt();
        0.4 * (4.0 / 3.0 * self.effective_modulus * contact_radius * overlap) * overlap
    }

    #[inline(always)]
    fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64 {
        2.0 * self.effective_modulus * (pair.radius * overlap).sqrt()
    }

    fn dashpots(&self, zeta: f64) -> [f64; 2] {
        let normal = 5f64.sqrt() * zeta;
        let ratio = 4.0 * self.effective_shear_modulus / self.effective_modulus;
        [normal, normal * ratio.sqrt()]
    }

    fn critical_dashpot(&self, pair: Reduced) -> f64 {
        5f64.sqrt() * pair.root_mass * self.stiffness(pair).sqrt()
    }

    fn exponent(&self) -> f64 {
        1.5
    }

    fn overlap_under(&self, force: f64, pair: Reduced) -> f64 {
        libm::pow(force / self.stiffness(pair), 2.0 / 3.0)
    }

    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        let mass = pair.root_mass * pair.root_mass;
        libm::pow(1.25 * mass * speed * speed / self.stiffness(pair), 0.4)
    }

    /// `2.9432 delta_max/v` (Landau & Lifshitz, *Theory of Elasticity*, sec. 9).
    fn contact_time(&self, pair: Reduced, speed: f64) -> f64 {
        2.943_225_5 * self.largest_overlap(pair, speed) / speed
    }

    fn name(&self) -> &'static str {
        "Hertz's law"
    }

    fn numbers(&self) -> Vec<(&'static str, f64, Bound)> {
        vec![
            ("effective_modulus", self.effective_modulus, Bound::Positive),
            ("effective_shear_modulus", self.effective_shear_modulus, Bound::NotNegative),
        ]
    }

    fn stiffness_in_words(&self) -> String {
        format!("an effective modulus of {} Pa under Hertz's law", short(self.effective_modulus))
    }

    fn remedy(&self, factor: f64) -> String {
        format!("Young's moduli {} times as large make it", short(factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::contact_law::Law;
    use crate::math::damping::restitution;
    use tremie_messages::scene::{ContactLaw, Damping, Spring};

    fn hertz(e: f64, tension: bool) -> Law {
        Law::new(&ContactLaw {
            spring: Spring::Hertz { effective_modulus: 2e9, effective_shear_modulus: 0.5e9 },
            friction: 0.3,
            rolling_friction: 0.0,
            damping: Damping::Restitution(e),
            tension,
        })
    }

    /// Rebound speed over impact speed, by small steps.
    fn rebound(law: &Law, speed: f64) -> f64 {
        let pair = Reduced { root_mass: 1e-6f64.sqrt(), radius: 1e-3, mean_mass: 2e-6 };
        let scale = 1e-6 * speed * speed / (2e9 * 1e-3f64.sqrt());
        let dt = 2e-5 * libm::pow(scale, 0.4) / speed;
        let (mut overlap, mut v) = (0.0, speed);
        loop {
            // Midpoint rule on (overlap, v).
            let force = |overlap: f64, v: f64| {
                let s = law.at(overlap.max(0.0), 0.0, pair);
                s.elastic + s.gamma_n * v
            };
            let (half, half_v) = (overlap + 0.5 * dt * v, v - 0.5 * dt * force(overlap, v) / 1e-6);
            let f = force(half, half_v);
            if (half <= 0.0 || (!law.tension && f < 0.0)) && v < 0.0 {
                return -v / speed;
            }
            (overlap, v) = (overlap + dt * half_v, v - dt * f / 1e-6);
        }
    }

    #[test]
    fn restitution_under_hertz_does_not_depend_on_the_speed() {
        for tension in [true, false] {
            for e in [0.3, 0.8] {
                for speed in [1e-3, 1.0, 30.0] {
                    let found = rebound(&hertz(e, tension), speed);
                    assert!((found - e).abs() < 2e-3, "{tension} {e} {speed}: {found}");
                }
            }
        }
        assert!(restitution(0.2, false) > restitution(0.2, true));
    }
}
