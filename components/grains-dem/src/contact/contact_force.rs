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
//! with `k_n delta` standing for any spring. Where bodies adhere, the largest pull `f_c` of the
//! spring bounds the force in place of 0, and `f_n + 2 f_c` bounds friction in place of `f_n`.
//! Rolling friction is the same in terms of the rolling velocity `v_r = R* (w_i - w_j)`, without
//! its part along n, with the limit `mu_r f_n` and the tangential spring and dashpot; its force
//! times `R*` is a torque on i, the opposite on j (Luding 2008; the spring `k_t R*^2` and the limit
//! `mu_r R* f_n` are those of Ai et al., *Powder Technol.* 206, 2011, type C, as what LIGGGHTS
//! calls EPSD2 has them; the dashpot `gamma_t R*^2` acts below the limit). Spinning about n is
//! free.
//!
//! Mutabaruka & Kamrin (2018, Eqs. 2-3) print the spring's sign for the opposite relative velocity
//! than the dashpot's; their sliding branch and Eq. 1 fix `v = v_i - v_j`, hence the minus.

use crate::Vec3;
use crate::bodies::body_arrays::Twist;
use crate::contact::contact_law::Law;
use crate::contact::friction::{FrameMotion, TangentialSpring, time_since_touch};
use crate::contact::springs::{Reduced, Stiffness};
use serde::{Deserialize, Serialize};

/// Geometry and kinematics of a contact at the end of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Unit normal from i to j.
    pub normal: Vec3,
    /// Overlap [m]; negative where there is a gap.
    pub overlap: f64,
    /// Velocity of i relative to j at the contact point [m/s].
    pub velocity: Vec3,
    /// Mean spin of both about the normal, `(w_i + w_j).n / 2` [rad/s].
    pub twist: f64,
    /// Angular velocity of i relative to j [rad/s].
    pub rolling: Vec3,
}

/// History of a contact: its state from step to step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactHistory {
    /// Tangential displacement [m], advanced by half a step beyond the last evaluation: the next
    /// one adds the other half, which makes its integration the trapezoidal rule.
    pub xi: Vec3,
    /// Rolling displacement [m], likewise.
    pub rolling: Vec3,
    /// Normal at the last evaluation.
    pub normal: Vec3,
    /// Overlap at the last evaluation [m].
    pub overlap: f64,
}

impl ContactHistory {
    /// The contact as the other body sees it.
    pub fn of_other_side(&self) -> Self {
        Self { xi: -self.xi, rolling: -self.rolling, normal: -self.normal, ..*self }
    }
}

/// Force of a contact on body i.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactForce {
    /// Normal force [N], positive when pushing: the force on i is `-f_n n`.
    pub normal: f64,
    /// Tangential force [N].
    pub tangential: Vec3,
    /// Torque that resists rolling [N·m], on i; j gets the opposite.
    pub rolling: Vec3,
}

/// Lengths of the step before an evaluation (0 for the very first, which starts all histories) and
/// of the one after it [s].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Steps {
    pub before: f64,
    pub after: f64,
}

/// Force of `contact`, which leaves in `memory` the history for the next step. What `memory` held
/// counts only if the pair was `touching` before.
#[inline(always)]
pub(crate) fn force(
    law: &Law,
    pair: Reduced,
    contact: &Contact,
    memory: &mut ContactHistory,
    touching: bool,
    steps: Steps,
) -> ContactForce {
    let n = contact.normal;
    let v_n = contact.velocity.dot(&n);
    let stiffness = law.at(contact.overlap, memory.overlap, pair);
    let mut f_n = stiffness.elastic + stiffness.gamma_n * v_n;
    if !law.tension {
        // Written so that without adhesion the bound is 0 and not -0.
        f_n = f_n.max(0.0 - stiffness.pull_off);
    }
    let old = memory.normal;
    memory.normal = n;
    memory.overlap = contact.overlap;
    let mut force = ContactForce { normal: f_n, ..ContactForce::default() };
    let motion = FrameMotion {
        n: n.into(),
        old: old.into(),
        twist: contact.twist,
        touching: f64::from(u8::from(touching)),
        since: if touching {
            0.0
        } else {
            time_since_touch(contact.overlap + law.gap, v_n, steps.before)
        },
        steps,
    };
    let Stiffness { k_t, inverse_k_t, gamma_t, remembered, pull_off, .. } = stiffness;
    // Where contacts adhere friction holds as under twice the largest pull besides (Thornton, *J.
    // Phys. D* 24, 1991).
    let pressing = (f_n + 2.0 * pull_off).max(0.0);
    let spring = TangentialSpring { k_t, inverse_k_t, gamma_t, remembered };
    if law.mu > 0.0 {
        let v_t = contact.velocity - n * v_n;
        let limit = law.mu * pressing;
        let (tangential, xi) = spring.resist(limit, memory.xi.into(), v_t.into(), &motion);
        (force.tangential, memory.xi) = (tangential.into(), xi.into());
    }
    if law.mu_rolling > 0.0 {
        let v_r = (contact.rolling - n * contact.rolling.dot(&n)) * pair.radius;
        let limit = law.mu_rolling * pressing;
        let (rolling, xi) = spring.resist(limit, memory.rolling.into(), v_r.into(), &motion);
        memory.rolling = xi.into();
        force.rolling = Vec3::from(rolling) * pair.radius;
    }
    force
}

/// The contact of two spheres with centres `d` apart. Its point lies half way between the two
/// surfaces; the overlap is negative where they do not touch.
#[inline(always)]
pub(crate) fn touch_of_balls(
    d: Vec3,
    radius_i: f64,
    radius_j: f64,
    i: &Twist,
    j: &Twist,
) -> Contact {
    let distance = d.norm_squared().sqrt();
    let normal = d * (1.0 / distance);
    let overlap = radius_i + radius_j - distance;
    let (arm_i, arm_j) = (radius_i - 0.5 * overlap, radius_j - 0.5 * overlap);
    Contact {
        normal,
        overlap,
        velocity: (i.v - j.v) + (i.w * arm_i + j.w * arm_j).cross(&normal),
        twist: 0.5 * (i.w + j.w).dot(&normal),
        rolling: i.w - j.w,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{ContactLaw, Damping, Spring};

    const PAIR: Reduced = Reduced { root_mass: 1.0, radius: 1e-3, mean_mass: 2.0 };

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
        Contact {
            normal,
            overlap: 1e-5,
            velocity: Vec3::zeros(),
            twist: 0.0,
            rolling: Vec3::zeros(),
        }
    }

    /// A stuck pair that turns as a rigid body once about an axis: |F_t| stays, its direction turns
    /// with the pair and ends where it began.
    fn turn_once(axis: Vec3, steps: usize) -> (f64, f64) {
        let law = law(10.0);
        let start = Vec3::x();
        let along = Vec3::new(0.0, 0.6, 0.8) * 1e-6;
        let mut memory =
            ContactHistory { xi: along, normal: start, overlap: 1e-5, ..ContactHistory::default() };
        let angle = core::f64::consts::TAU / steps as f64;
        let first = -along * 0.8e5;
        let (mut length_error, mut last) = (0.0f64, first);
        for k in 1..=steps {
            let turn = nalgebra::Rotation3::from_scaled_axis(axis * (angle * k as f64));
            let mut contact = still(turn * start);
            // Both bodies turn at `angle` per step of length 1.
            contact.twist = angle * axis.dot(&contact.normal);
            last =
                force(&law, PAIR, &contact, &mut memory, true, Steps { before: 1.0, after: 1.0 })
                    .tangential;
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
        let mut memory = ContactHistory::default();
        let mut contact = still(Vec3::z());
        contact.velocity = Vec3::new(3.0, 4.0, 0.0);
        let f =
            force(&law, PAIR, &contact, &mut memory, false, Steps { before: 1e-3, after: 1e-3 });
        assert_eq!(f.normal, 1.0);
        assert!((f.tangential - Vec3::new(-0.24, -0.32, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn the_spring_does_not_grow_while_sliding() {
        let law = law(0.4);
        let mut memory = ContactHistory::default();
        let mut contact = still(Vec3::z());
        contact.velocity = Vec3::new(1.0, 0.0, 0.0);
        for _ in 0..100 {
            force(&law, PAIR, &contact, &mut memory, true, Steps { before: 1e-6, after: 1e-6 });
        }
        contact.velocity = Vec3::zeros();
        force(&law, PAIR, &contact, &mut memory, true, Steps { before: 0.0, after: 0.0 });
        assert!(memory.xi.norm() <= 0.4 / 0.8e5 * (1.0 + 1e-12));
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
        let mut memory = ContactHistory::default();
        let pull =
            force(&damped, PAIR, &contact, &mut memory, true, Steps { before: 1e-6, after: 1e-6 });
        assert_eq!(pull.normal, 0.0);
        let mut pulling = damped;
        pulling.tension = true;
        let pull =
            force(&pulling, PAIR, &contact, &mut memory, true, Steps { before: 1e-6, after: 1e-6 });
        assert_eq!(pull.normal, -2.0);
    }
}
