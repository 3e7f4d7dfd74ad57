//! Heun's method.
//!
//! ```text
//! U_a = U + dt a(X, U)                           X_a = X + dt (U + U_a)/2
//! U'  = U + dt (a(X, U) + a(X_a, U_a))/2         X'  = X + dt (U + U')/2
//! ```
//!
//! and the same for angular velocities and orientations. `X_a` is where Verlet's method goes, with
//! `U_a` what it predicts, so that a step is one of Verlet's and what is added here: with the
//! velocity half way, `v_h = U + dt/2 a(X, U)`,
//!
//! ```text
//! U' = v_h + dt/2 a(X_a, U_a)                    X' = X_a + dt/2 (U' - U_a)
//! ```
//!
//! Forces are evaluated at `X_a` and at `X'`. Tangential springs go through the step in the first
//! of these evaluations; in the second they turn with the pair alone.

use crate::bodies::body_arrays::Twist;
use crate::bodies::deformable_surface::SurfaceState;
use crate::contact::contact_force::Steps;
use crate::math::error::GrainsError;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::moved_bodies::MovedBody;

impl GrainsDem {
    /// Evaluates the forces where the step of Verlet's led, corrects the motion, and evaluates them
    /// there.
    pub(super) fn correct_and_evaluate(
        &mut self,
        surfaces: &[SurfaceState<'_>],
    ) -> Result<(), GrainsError> {
        let dt = self.stepping.dt;
        // Contacts count where a step ends.
        let deep = self.record.deep_overlaps;
        self.evaluate_forces(Steps { before: dt, after: 0.0 }, surfaces)?;
        self.record.deep_overlaps = deep;
        self.account_of_bands(0.5 * dt);
        self.move_bodies(0.5 * dt, |body| correction(body, 0.5 * dt));
        let due = self.follow_bodies();
        if due {
            self.check_inside()?;
            self.rebuild_lists();
        }
        self.evaluate_forces(Steps { before: 0.0, after: dt }, surfaces)
    }
}

/// Gives a body its velocities at the end of a step, and returns their difference from the
/// predicted ones.
#[inline(always)]
fn correction(body: MovedBody<'_>, half: f64) -> Twist {
    if !body.is_free {
        return Twist::zero();
    }
    body.twist.kick(&body.by_contacts, half);
    body.twist.kick(&body.applied, half);
    let (end, seen) = (*body.twist, *body.predicted);
    *body.predicted = end;
    Twist { v: end.v - seen.v, w: end.w - seen.w }
}
