//! The force in one contact.
//!
//! For the pair (i, j) every vector acts on i; j gets the opposite. `n` points from i to j,
//! `delta > 0` is the overlap, `v` the velocity of i relative to j at the contact point and `v_n =
//! v.n`, positive while approaching (Cundall & Strack 1979; Luding 2008):
//!
//! ```text
//! f_n  = max(0, k_n delta + gamma_n v_n)       without max() where the dashpot may pull
//! F_t* = -k_t xi - gamma_t v_t                 d(xi)/dt = v_t
//! F_t  = F_t*                                  if |F_t*| <= mu f_n
//!        mu f_n F_t*/|F_t*|                    else, and xi := -(F_t + gamma_t v_t)/k_t
//! F    = F_t - f_n n
//! ```
//!
//! Mutabaruka & Kamrin (2018, Eqs. 2-3) print the spring's sign for the opposite relative velocity
//! than the dashpot's; their sliding branch and Eq. 1 fix `v = v_i - v_j`, hence the minus.

use crate::{Vec3, law::Law};

/// Geometry and kinematics of a contact at the end of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Unit normal from i to j.
    pub normal: Vec3,
    /// Overlap [m], positive.
    pub overlap: f64,
    /// Velocity of i relative to j at the contact point [m/s].
    pub velocity: Vec3,
    /// Mean spin of both about the normal, `(w_i + w_j).n / 2` [rad/s].
    pub twist: f64,
}

/// What a contact remembers from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Memory {
    /// Tangential displacement [m], advanced by half a step beyond the last evaluation: the next
    /// one adds the other half, which makes its integration the trapezoidal rule.
    pub xi: Vec3,
    /// Normal at the last evaluation.
    pub normal: Vec3,
}

/// Force of a contact on body i.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactForce {
    /// Normal force [N], positive when pushing: the force on i is `-f_n n`.
    pub normal: f64,
    /// Tangential force [N].
    pub tangential: Vec3,
}

/// Force of `contact` after a step of length `dt` (0 for the very first evaluation, which starts
/// all histories), leaving in `memory` what the next step of length `next_dt` needs. What `memory`
/// held counts only if the pair was `touching` before.
#[inline(always)]
pub(crate) fn force(
    law: &Law,
    root_mass: f64,
    contact: &Contact,
    memory: &mut Memory,
    touching: bool,
    dt: f64,
    next_dt: f64,
) -> ContactForce {
    let n = contact.normal;
    let v_n = contact.velocity.dot(&n);
    let mut f_n = law.k_n * contact.overlap + law.gamma_n(root_mass) * v_n;
    if !law.tension {
        f_n = f_n.max(0.0);
    }
    if law.mu == 0.0 {
        return ContactForce { normal: f_n, tangential: Vec3::zeros() };
    }
    let v_t = contact.velocity - n * v_n;
    let mut xi = if touching {
        turned(memory, n, contact.twist * dt) + v_t * (0.5 * dt)
    } else {
        v_t * time_since_touch(contact.overlap, v_n, dt)
    };
    xi -= n * xi.dot(&n);

    let damping = v_t * law.gamma_t(root_mass);
    let trial = -(xi * law.k_t + damping);
    let limit = law.mu * f_n.max(0.0);
    let square = trial.norm_squared();
    let tangential = if square <= limit * limit {
        trial
    } else {
        let slipping = trial * (limit / square.sqrt());
        xi = (slipping + damping) * -law.inverse_k_t;
        slipping
    };
    memory.xi = xi + v_t * (0.5 * next_dt);
    memory.normal = n;
    ContactForce { normal: f_n, tangential }
}

/// How long ago two bodies met that overlap by `overlap` and approach at `v_n`; at most `dt`.
#[inline(always)]
fn time_since_touch(overlap: f64, v_n: f64, dt: f64) -> f64 {
    if overlap < v_n * dt { overlap / v_n } else { dt }
}

/// The remembered displacement, turned with the pair: by the rotation that takes the old normal
/// to `n`, then by `angle` about `n`.
#[inline(always)]
fn turned(memory: &Memory, n: Vec3, angle: f64) -> Vec3 {
    let (xi, old) = (memory.xi, memory.normal);
    // Rodrigues' formula between two unit vectors a, b, for xi normal to a:
    // R xi = xi - (xi.b)/(1 + a.b) (a + b)
    let xi = xi - (old + n) * (xi.dot(&n) / (1.0 + old.dot(&n)));
    // Cayley's form of a rotation keeps lengths exactly and needs no trigonometric function.
    let t = 0.5 * angle;
    let cross = n.cross(&xi);
    xi + (cross - xi * t) * (2.0 * t / (1.0 + t * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{ContactLaw, Damping, Spring};

    fn law(mu: f64) -> Law {
        Law::new(&ContactLaw {
            spring: Spring::Linear { normal_stiffness: 1e5, tangential_stiffness: 0.8e5 },
            friction: mu,
            rolling_friction: 0.0,
            damping: Damping::Coefficients { normal: 0.0, tangential: 0.0 },
            tension: false,
        })
    }

    fn still(normal: Vec3) -> Contact {
        Contact { normal, overlap: 1e-5, velocity: Vec3::zeros(), twist: 0.0 }
    }

    /// A stuck pair that turns as a rigid body once about an axis: |F_t| stays, its direction turns
    /// with the pair and ends where it began.
    fn turn_once(axis: Vec3, steps: usize) -> (f64, f64) {
        let law = law(10.0);
        let start = Vec3::x();
        let along = Vec3::new(0.0, 0.6, 0.8) * 1e-6;
        let mut memory = Memory { xi: along, normal: start };
        let angle = core::f64::consts::TAU / steps as f64;
        let first = -along * law.k_t;
        let (mut length_error, mut last) = (0.0f64, first);
        for k in 1..=steps {
            let turn = nalgebra::Rotation3::from_scaled_axis(axis * (angle * k as f64));
            let mut contact = still(turn * start);
            // Both bodies turn at `angle` per step of length 1.
            contact.twist = angle * axis.dot(&contact.normal);
            last = force(&law, 1.0, &contact, &mut memory, true, 1.0, 1.0).tangential;
            length_error = length_error.max((last.norm() / first.norm() - 1.0).abs());
        }
        (length_error, (last - first).norm() / first.norm())
    }

    #[test]
    fn tangential_force_turns_with_a_stuck_pair() {
        for axis in [Vec3::z(), Vec3::x(), Vec3::new(0.48, 0.6, 0.64)] {
            let (length, direction) = turn_once(axis, 1000);
            assert!(length < 1e-12, "{length}");
            assert!(direction < 1e-4, "{direction}");
            let (_, finer) = turn_once(axis, 2000);
            assert!(finer < 0.26 * direction || finer < 1e-11, "{finer} {direction}");
        }
    }

    #[test]
    fn sliding_force_is_at_the_limit_and_against_the_motion() {
        let law = law(0.4);
        let mut memory = Memory::default();
        let mut contact = still(Vec3::z());
        contact.velocity = Vec3::new(3.0, 4.0, 0.0);
        let f = force(&law, 1.0, &contact, &mut memory, false, 1e-3, 1e-3);
        assert_eq!(f.normal, 1.0);
        assert!((f.tangential - Vec3::new(-0.24, -0.32, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn the_spring_does_not_grow_while_sliding() {
        let law = law(0.4);
        let mut memory = Memory::default();
        let mut contact = still(Vec3::z());
        contact.velocity = Vec3::new(1.0, 0.0, 0.0);
        for _ in 0..100 {
            force(&law, 1.0, &contact, &mut memory, true, 1e-6, 1e-6);
        }
        contact.velocity = Vec3::zeros();
        force(&law, 1.0, &contact, &mut memory, true, 0.0, 0.0);
        assert!(memory.xi.norm() <= 0.4 / law.k_t * (1.0 + 1e-12));
    }

    #[test]
    fn without_tension_the_dashpot_cannot_pull() {
        let damped = Law::new(&ContactLaw {
            spring: Spring::Linear { normal_stiffness: 1e5, tangential_stiffness: 0.0 },
            friction: 0.0,
            rolling_friction: 0.0,
            damping: Damping::Coefficients { normal: 3.0, tangential: 0.0 },
            tension: false,
        });
        let mut contact = still(Vec3::z());
        contact.velocity = Vec3::new(0.0, 0.0, -1.0);
        let mut memory = Memory::default();
        let pull = force(&damped, 1.0, &contact, &mut memory, true, 1e-6, 1e-6);
        assert_eq!(pull.normal, 0.0);
        let mut pulling = damped;
        pulling.tension = true;
        let pull = force(&pulling, 1.0, &contact, &mut memory, true, 1e-6, 1e-6);
        assert_eq!(pull.normal, -2.0);
    }
}
