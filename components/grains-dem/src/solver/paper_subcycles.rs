//! The subcycles that Chen et al. (2019, Eqs. 21-25) print.
//!
//! ```text
//! U_0 = U^n + dt_f (F + G)/M                     loads F and weight G over the whole window dt_f
//! U_k = U_(k-1) + dt a(X_(k-1), U_(k-1))         X_k = X_(k-1) + dt (U^n + U_k)/2
//! ```
//!
//! with `U^n` the velocity at the start of the window, the step of the fluid, and `a` the
//! acceleration by contacts; the same for angular velocities and orientations. Where nothing touches this is the
//! trapezoidal rule over the window. Contacts see a velocity that lags behind in what moves the
//! body, so that a rebound within a window gains energy, the more the longer the window is over the
//! contact, which the authors' damping hides.
//!
//! Within a window `twists` hold `U^n` and the predicted velocities `U_k`.

use crate::bodies::body_arrays::Twist;
use crate::solver::dem_solver::GrainsDem;
use crate::solver::moved_bodies::MovedBody;

impl GrainsDem {
    /// Moves the bodies through a substep, that which begins a window if it is the `first`.
    pub(super) fn move_in_window(&mut self, first: bool) {
        let dt = self.stepping.dt;
        let window = first.then(|| f64::from(self.stepping.window) * dt);
        self.account_of_bands(dt);
        self.move_bodies(dt, |body| substep(body, dt, window));
    }

    /// Ends a window: the velocities are the last ones.
    pub(super) fn end_subcycles(&mut self) {
        let bodies = &mut self.population.bodies;
        bodies.twists.copy_from_slice(&bodies.predicted);
    }
}

/// Gives a body its next velocities, and returns those that move it. The first time in a window
/// loads and weight act, over the `window` [s].
#[inline(always)]
fn substep(body: MovedBody<'_>, dt: f64, window: Option<f64>) -> Twist {
    if !body.is_free {
        return *body.twist;
    }
    if let Some(window) = window {
        *body.predicted = *body.twist;
        body.predicted.kick(&body.applied, window);
    }
    body.predicted.kick(&body.by_contacts, dt);
    let (start, now) = (*body.twist, *body.predicted);
    Twist { v: (start.v + now.v) * 0.5, w: (start.w + now.w) * 0.5 }
}
