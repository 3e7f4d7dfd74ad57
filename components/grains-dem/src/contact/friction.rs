//! The spring of friction, which remembers: of spheres one by one, side by side in registers, and
//! of polyhedra.
//!
//! ```text
//! F_t* = -k_t xi - gamma_t v_t                 d(xi)/dt = v_t, turning with the pair
//! F_t  = F_t*                                  if |F_t*| <= limit
//!        limit F_t*/|F_t*|                     else, and xi := -(F_t + gamma_t v_t)/k_t
//! ```
//!
//! (Cundall and Strack 1979; Luding 2008). What is remembered is half a step ahead of the last
//! evaluation; the next one adds the other half, which makes the integration the trapezoidal rule.
//! Everything is written over [`SimdLane`]: a number alone branches, registers hold both answers
//! and choose.

use crate::contact::contact_force::Steps;
use crate::math::simd::lanes::Lane3;
use tremie_team::simd::SimdLane;

/// Motion of a contact's frame in the step before an evaluation, and whether the contact was there
/// before.
#[derive(Clone, Copy)]
pub(crate) struct FrameMotion<L> {
    /// Normals now and at the last evaluation.
    pub n: Lane3<L>,
    pub old: Lane3<L>,
    /// Mean spin of both bodies about the normal [rad/s].
    pub twist: L,
    /// 1 where they touched before, else 0; and how long ago they met where they did not [s].
    pub touching: L,
    pub since: L,
    pub steps: Steps,
}

impl<L: SimdLane> FrameMotion<L> {
    /// The displacement at this evaluation, from what was `remembered` and the velocity `v` across
    /// the normal.
    #[inline(always)]
    pub fn displacement(&self, remembered: Lane3<L>, v: Lane3<L>) -> Lane3<L> {
        let (like, n, dt) = (self.touching, self.n, self.steps.before);
        let fresh = v * self.since;
        let xi = if like.none_above(like.all(0.0)) {
            fresh
        } else {
            let kept = turned(remembered, self.old, n, self.twist * like.all(dt));
            Lane3::at_most(like, like.all(0.0), fresh, kept + v * like.all(0.5 * dt))
        };
        xi - n * xi.dot(n)
    }

    /// Displacement advanced by half of the next step, to be stored in the history.
    #[inline(always)]
    pub fn ahead(&self, xi: Lane3<L>, v: Lane3<L>) -> Lane3<L> {
        xi + v * self.touching.all(0.5 * self.steps.after)
    }
}

/// Spring and dashpot across the normal.
#[derive(Clone, Copy)]
pub(crate) struct TangentialSpring<L> {
    /// Stiffness [N/m], its inverse or 0 without a spring, dashpot [kg/s].
    pub k_t: L,
    pub inverse_k_t: L,
    pub gamma_t: L,
    /// Factor on remembered displacements since the last evaluation.
    pub remembered: L,
}

impl<L: SimdLane> TangentialSpring<L> {
    /// Displacement, damping and force if nothing slips.
    #[inline(always)]
    fn trial(
        &self,
        remembered: Lane3<L>,
        v: Lane3<L>,
        motion: &FrameMotion<L>,
    ) -> (Lane3<L>, Lane3<L>, Lane3<L>) {
        let xi = motion.displacement(remembered * self.remembered, v);
        let damping = v * self.gamma_t;
        (xi, damping, -(xi * self.k_t + damping))
    }

    /// The force at the velocity `v`, which has no part along the normal, and the displacement to
    /// remember. Where it slips, the spring gives way and the dashpot does not.
    #[inline(always)]
    pub fn resist(
        &self,
        limit: L,
        remembered: Lane3<L>,
        v: Lane3<L>,
        motion: &FrameMotion<L>,
    ) -> (Lane3<L>, Lane3<L>) {
        let (xi, damping, trial) = self.trial(remembered, v, motion);
        let (square, capacity) = (trial.dot(trial), limit * limit);
        if square.none_above(capacity) {
            return (trial, motion.ahead(xi, v));
        }
        let slipping = trial * (limit / square.sqrt());
        let pulled = (slipping + damping) * -self.inverse_k_t;
        let force = Lane3::at_most(square, capacity, trial, slipping);
        (force, motion.ahead(Lane3::at_most(square, capacity, xi, pulled), v))
    }

    /// Resistance where spring and dashpot give way alike, so that a soft contact that begins does
    /// not find its spring stretched against the dashpot: the force, and the displacement at this
    /// evaluation.
    #[inline(always)]
    pub fn resist_alike(
        &self,
        limit: L,
        remembered: Lane3<L>,
        v: Lane3<L>,
        motion: &FrameMotion<L>,
    ) -> (Lane3<L>, Lane3<L>) {
        let (xi, _, trial) = self.trial(remembered, v, motion);
        let (square, capacity) = (trial.dot(trial), limit * limit);
        if square.none_above(capacity) {
            return (trial, xi);
        }
        let slip = limit / square.sqrt();
        let force = Lane3::at_most(square, capacity, trial, trial * slip);
        (force, Lane3::at_most(square, capacity, xi, xi * slip))
    }
}

/// Time since two bodies met that overlap by `overlap` and approach at `v_n` [s]; at most `dt`.
#[inline(always)]
pub(crate) fn time_since_touch<L: SimdLane>(overlap: L, v_n: L, dt: f64) -> L {
    overlap.less(v_n * v_n.all(dt), overlap / v_n, v_n.all(dt))
}

/// The displacement `xi` across `old`, turned with the pair: by the rotation that takes the old
/// normal to `n`, then by `angle` about `n`.
#[inline(always)]
fn turned<L: SimdLane>(xi: Lane3<L>, old: Lane3<L>, n: Lane3<L>, angle: L) -> Lane3<L> {
    let one = angle.all(1.0);
    // Rodrigues' formula between two unit vectors a, b, for xi normal to a:
    // R xi = xi - (xi.b)/(1 + a.b) (a + b)
    let xi = xi - (old + n) * (xi.dot(n) / (one + old.dot(n)));
    // Cayley's form of a rotation keeps lengths exactly and needs no trigonometric function.
    let t = angle.all(0.5) * angle;
    let cross = n.cross(xi);
    xi + (cross - xi * t) * (angle.all(2.0) * t / (one + t * t))
}
