//! A contact law in the form that the inner loop wants.
//!
//! Hertz and Mindlin: with `k_H = 4/3 E* sqrt(R*)`,
//!
//! ```text
//! f_n = k_H delta^(3/2) + gamma_n v_n        gamma_n = sqrt(5) zeta sqrt(k_H m*) delta^(1/4)
//! k_t = 8 G* sqrt(R* delta)                  gamma_t = gamma_n sqrt(k_t/k_n),  k_n = 2 E* sqrt(R* delta)
//! ```
//!
//! In terms of `q = sqrt(4/5 k_H/m*) delta^(5/4)` and the phase `ds = sqrt(5/4 k_H/m*) delta^(1/4) dt`
//! a collision under this dashpot is that of a linear spring with damping ratio `zeta`, speed by
//! speed: `dq/ds = v`, `dv/ds = -q - 2 zeta v` (Antypov & Elliott, *EPL* 94, 2011, whose alpha is
//! `sqrt(5) zeta`; the form of the dashpot is that of Tsuji, Tanaka & Ishida, *Powder Technol.* 71,
//! 1992). So the restitution does not depend on the speed, and damping ratio and restitution go
//! together as for linear springs, with and without tension.

use crate::contact::contact_force::ContactHistory;
use crate::math::damping::damping_ratio;
use tremie_messages::scene::{ContactLaw, Damping, Spring};

/// Springs, dashpots, friction; the dashpots as functions of the pair's reduced mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// The springs.
    pub spring: Spring,
    /// Coefficient of friction.
    pub mu: f64,
    /// Coefficient of rolling friction.
    pub mu_rolling: f64,
    /// Whether the dashpot may pull.
    pub tension: bool,
    /// `1/k_t` of linear springs, or 0 without one [m/N].
    inverse_k_t: f64,
    gamma_n: Dashpot,
    gamma_t: Dashpot,
}

/// A dashpot's coefficient [kg/s] as `fixed + per_root_mass sqrt(m*)`. Under Hertz's law,
/// `per_root_mass sqrt(m* k_H) delta^(1/4)`.
#[derive(Clone, Copy, Debug)]
struct Dashpot {
    fixed: f64,
    per_root_mass: f64,
}

/// Reduced quantities of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C)]
pub(crate) struct Reduced {
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: f64,
    /// `R*` [m].
    pub radius: f64,
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
}

impl Law {
    /// The law of a scene. With a given restitution the damping ratio is the same for all pairs:
    /// under linear springs `gamma_n = 2 zeta sqrt(k_n m*)`, and `gamma_t = gamma_n sqrt(k_t/k_n)`.
    pub fn new(law: &ContactLaw) -> Self {
        let constant = |gamma| Dashpot { fixed: gamma, per_root_mass: 0.0 };
        let scaled = |per_root_mass| Dashpot { fixed: 0.0, per_root_mass };
        let zeta = |e| damping_ratio(e, law.tension);
        let (gamma_n, gamma_t) = match (law.spring, law.damping) {
            (_, Damping::Coefficients { normal, tangential }) => {
                (constant(normal), constant(tangential))
            }
            (
                Spring::Linear { normal_stiffness, tangential_stiffness },
                Damping::Restitution(e),
            ) => {
                let twice = 2.0 * zeta(e);
                (
                    scaled(twice * normal_stiffness.sqrt()),
                    scaled(twice * tangential_stiffness.sqrt()),
                )
            }
            (
                Spring::Hertz { effective_modulus, effective_shear_modulus },
                Damping::Restitution(e),
            ) => {
                let normal = 5f64.sqrt() * zeta(e);
                let ratio = 4.0 * effective_shear_modulus / effective_modulus;
                (scaled(normal), scaled(normal * ratio.sqrt()))
            }
        };
        Self {
            spring: law.spring,
            mu: law.friction,
            mu_rolling: law.rolling_friction,
            tension: law.tension,
            inverse_k_t: match law.spring {
                Spring::Linear { tangential_stiffness: k, .. } if k > 0.0 => 1.0 / k,
                _ => 0.0,
            },
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

    /// The same without friction of any kind.
    pub fn without_friction(&self) -> Self {
        Self { mu: 0.0, mu_rolling: 0.0, ..*self }
    }

    /// Normal and tangential dashpot as `[fixed, per sqrt(m*)]`.
    pub fn dashpots(&self) -> ([f64; 2], [f64; 2]) {
        let of = |dashpot: Dashpot| [dashpot.fixed, dashpot.per_root_mass];
        (of(self.gamma_n), of(self.gamma_t))
    }

    /// `1/k_t` of linear springs, or 0 without one [m/N].
    pub fn inverse_k_t(&self) -> f64 {
        self.inverse_k_t
    }

    /// Springs and dashpots at an overlap, after `before` at the last evaluation [m].
    ///
    /// Under Mindlin's law the tangential force of a growing overlap does not grow with the spring,
    /// so the remembered displacement shrinks; that of a falling one falls with it, so the
    /// displacement stays (Thornton, Cummins & Cleary, *Powder Technol.* 233, 2013; what LAMMPS
    /// calls `mindlin_rescale/force`). Otherwise the spring would make energy.
    #[inline(always)]
    pub fn at(&self, overlap: f64, before: f64, pair: Reduced) -> Stiffness {
        match self.spring {
            Spring::Linear { normal_stiffness, tangential_stiffness } => Stiffness {
                elastic: normal_stiffness * overlap,
                gamma_n: self.gamma_n.fixed + self.gamma_n.per_root_mass * pair.root_mass,
                k_t: tangential_stiffness,
                inverse_k_t: self.inverse_k_t,
                gamma_t: self.gamma_t.fixed + self.gamma_t.per_root_mass * pair.root_mass,
                remembered: 1.0,
            },
            Spring::Hertz { effective_modulus, effective_shear_modulus } => {
                let contact_radius = (pair.radius * overlap).sqrt();
                let hertz = 4.0 / 3.0 * effective_modulus * contact_radius;
                // sqrt(m* k_H) delta^(1/4) = sqrt(m* k_H sqrt(delta)), and hertz = k_H sqrt(delta).
                let damping = pair.root_mass * hertz.sqrt();
                let k_t = 8.0 * effective_shear_modulus * contact_radius;
                Stiffness {
                    elastic: hertz * overlap,
                    gamma_n: self.gamma_n.fixed + self.gamma_n.per_root_mass * damping,
                    k_t,
                    inverse_k_t: if k_t > 0.0 { 1.0 / k_t } else { 0.0 },
                    gamma_t: self.gamma_t.fixed + self.gamma_t.per_root_mass * damping,
                    remembered: if before < overlap { (before / overlap).sqrt() } else { 1.0 },
                }
            }
        }
    }

    /// Elastic energy of the normal spring [J].
    pub fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        let elastic = self.at(overlap, overlap, pair).elastic;
        let share = match self.spring {
            Spring::Linear { .. } => 0.5,
            Spring::Hertz { .. } => 0.4,
        };
        share * elastic * overlap
    }

    /// What the spring of a contact alone brings into a region of contacts: the square root of twice its energy, see
    /// [`crate::contact::region_shares`]. Nothing where it does not touch.
    pub fn normal_root(&self, overlap: f64, pair: Reduced) -> f64 {
        (2.0 * self.normal_energy(overlap.max(0.0), pair)).sqrt()
    }

    /// Energy that a contact's springs hold [J], by what it remembers.
    pub fn remembered_energy(&self, memory: &ContactHistory, pair: Reduced) -> f64 {
        let k_t = self.at(memory.overlap, memory.overlap, pair).k_t;
        let across = memory.xi.norm_squared() + memory.rolling.norm_squared();
        self.normal_energy(memory.overlap, pair) + 0.5 * k_t * across
    }

    /// Slope of the elastic normal force over the overlap [N/m].
    pub fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64 {
        match self.spring {
            Spring::Linear { normal_stiffness, .. } => normal_stiffness,
            Spring::Hertz { effective_modulus, .. } => {
                2.0 * effective_modulus * (pair.radius * overlap).sqrt()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::damping::restitution;

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
        let pair = Reduced { root_mass: 1e-6f64.sqrt(), radius: 1e-3 };
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
