//! Velocity Verlet with predicted velocities.
//!
//! ```text
//! v_h = v + dt/2 a        x += dt v_h        v_p = v_h + dt/2 a      forces see x and v_p
//! a = F(x, v_p, w_p)/m + g                   v = v_h + dt/2 a
//! ```
//!
//! and the same for the angular velocity. Forces at the half-step velocity would leave the scheme
//! first order, because dashpots depend on it (the prediction is that of Groot & Warren, *J. Chem. Phys.* 107,
//! 1997, with lambda = 1).

use crate::{
    Vec3,
    bodies::{Bodies, Mobility, Twist, Wrench},
};

/// Acceleration and angular acceleration of a body under two wrenches and weight.
#[inline(always)]
fn acceleration(contact: &Wrench, load: &Wrench, mobility: Mobility, gravity: Vec3) -> Twist {
    let gravity = if mobility.is_free() { gravity } else { Vec3::zeros() };
    Twist {
        v: (contact.force + load.force) * mobility.inverse_mass + gravity,
        w: (contact.torque + load.torque) * mobility.inverse_inertia,
    }
}

impl Twist {
    #[inline(always)]
    fn kick(&mut self, a: &Twist, dt: f64) {
        self.v += a.v * dt;
        self.w += a.w * dt;
    }
}

/// First half of a substep: half kick, drift, prediction; contact forces are used up and set to
/// zero. With `finish` the half kick that ends the substep before comes first, so that bodies are
/// visited once a substep. Returns the square of the largest distance of a body from its
/// `reference` position; NaN if any is.
pub(crate) fn first_half(
    bodies: &mut Bodies,
    gravity: Vec3,
    dt: f64,
    finish: bool,
    reference: &[Vec3],
) -> f64 {
    let half = 0.5 * dt;
    let n = bodies.len();
    // Slices of equal length spare the loop its bounds checks.
    let (balls, reference) = (&mut bodies.balls[..n], &reference[..n]);
    let (twists, predicted) = (&mut bodies.twists[..n], &mut bodies.predicted[..n]);
    let (contact, load) = (&mut bodies.contact[..n], &bodies.load[..n]);
    let (mobility, orientation) = (&bodies.mobility[..n], &mut bodies.orientation[..n]);
    let mut farthest = 0.0;
    for i in 0..n {
        let a = acceleration(&contact[i], &load[i], mobility[i], gravity);
        contact[i] = Wrench::zero();
        let mut twist = twists[i];
        if finish {
            twist.kick(&a, half);
        }
        twist.kick(&a, half);
        twists[i] = twist;
        predicted[i] = twist;
        predicted[i].kick(&a, half);
        balls[i].x += twist.v * dt;
        let square = (balls[i].x - reference[i]).norm_squared();
        if square > farthest || square.is_nan() {
            farthest = square;
        }
        orientation[i] = turned(orientation[i], twist.w * half);
    }
    farthest
}

/// Second half of a substep: half kick with the new forces.
pub(crate) fn second_half(bodies: &mut Bodies, gravity: Vec3, dt: f64) {
    for i in 0..bodies.len() {
        let (contact, load) = (&bodies.contact[i], &bodies.load[i]);
        let a = acceleration(contact, load, bodies.mobility[i], gravity);
        bodies.twists[i].kick(&a, 0.5 * dt);
    }
}

/// The orientation `q` turned by a small rotation, given as half its angle along its axis in the
/// world frame: `q + (h, 0) q`, renormalised, is exact to third order in the angle.
#[inline(always)]
fn turned(q: [f64; 4], h: Vec3) -> [f64; 4] {
    let [x, y, z, w] = q;
    let turned = [
        x + h.x * w + h.y * z - h.z * y,
        y + h.y * w + h.z * x - h.x * z,
        z + h.z * w + h.x * y - h.y * x,
        w - h.x * x - h.y * y - h.z * z,
    ];
    let square = turned.iter().fold(0.0, |sum, c| sum + c * c);
    turned.map(|c| c * (1.0 / square.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_follows_a_steady_rotation() {
        let w = Vec3::new(0.3, -0.4, 1.2);
        let steps = 2000;
        let mut q = [0.0, 0.0, 0.0, 1.0];
        for _ in 0..steps {
            q = turned(q, w * (0.5 / f64::from(steps)));
        }
        let exact = nalgebra::UnitQuaternion::from_scaled_axis(w);
        let error = (0..4).map(|a| (q[a] - exact.coords[a]).abs()).fold(0.0, f64::max);
        assert!(error < 1e-7, "{error}");
    }
}
