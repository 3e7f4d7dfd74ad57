//! The subcycles that Chen et al. (2019, Eqs. 21-25) print.
//!
//! ```text
//! U_k = U_(k-1) + dt a(X_(k-1), U_(k-1))         X_k = X_(k-1) + dt (U^n + U_k)/2
//! ```
//!
//! with `U^n` the velocity at the start of the window, the step of the fluid; and the same for
//! angular velocities and orientations. Under forces that are constant over the window they end
//! where the trapezoidal rule does. Under those of a contact they do not: with more than one step a
//! window the velocity that moves a body lags behind, and a rebound within a window gains energy,
//! which the authors' damping hides.
//!
//! Within a window `twists` hold `U^n` and the predicted velocities `U_k`.

use crate::bodies::body_arrays::Twist;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::integrate::AppliedForces;
use crate::solver::moved_bodies::{MovedBody, move_bodies};

impl GrainsDem {
    /// Moves the bodies through a substep, that which begins a window if it is the `first`.
    pub(super) fn move_in_window(&mut self, first: bool) {
        let dt = self.stepping.dt;
        let forces = AppliedForces {
            contacts: self.search.contacts(),
            loaded: self.fluid.loaded,
            gravity: self.gravity,
        };
        move_bodies(
            &mut self.threads.team,
            &mut self.population.bodies,
            (&self.around.bounds, self.search.leash()),
            forces,
            dt,
            &mut self.record.reaches,
            |body| substep(body, dt, first),
        );
    }

    /// Ends a window: the velocities are the last ones.
    pub(super) fn end_subcycles(&mut self) {
        let bodies = &mut self.population.bodies;
        bodies.twists.copy_from_slice(&bodies.predicted);
    }
}

/// Gives a body its next velocities, and returns those that move it.
#[inline(always)]
fn substep(body: MovedBody<'_>, dt: f64, first: bool) -> Twist {
    if !body.is_free {
        return *body.twist;
    }
    if first {
        *body.predicted = *body.twist;
    }
    body.predicted.kick(&body.acceleration, dt);
    let (start, now) = (*body.twist, *body.predicted);
    Twist { v: (start.v + now.v) * 0.5, w: (start.w + now.w) * 0.5 }
}
