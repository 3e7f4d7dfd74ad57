//! Free rotation of bodies with three moments of inertia.
//!
//! The state is orientation and angular momentum in the world, kicked as velocities are. In between
//! the body turns freely, by rotations about its principal axes one after the other,
//!
//! ```text
//! R1(dt/2) R2(dt/2) R3(dt) R2(dt/2) R1(dt/2),     R_k turns about axis k by dt P_k/I_k
//! ```
//!
//! each of them exact (Dullweber, Leimkuhler & McLachlan, *J. Chem. Phys.* 107, 1997): of second
//! order, the angular momentum stays what it is, and the energy does not drift.

use super::shape::{to_body, to_world, turned_axes};
use crate::Vec3;
use serde::{Deserialize, Serialize};

/// Moments of inertia [kg·m²] about unit vectors in the body.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Inertia {
    pub moments: [f64; 3],
    pub axes: [Vec3; 3],
}

impl Inertia {
    /// The angular velocity at an orientation, of an angular momentum [rad/s].
    pub fn spin(&self, q: [f64; 4], momentum: Vec3) -> Vec3 {
        let frame = turned_axes(q);
        let mut spin = Vec3::zeros();
        for k in 0..3 {
            let axis = to_world(&frame, self.axes[k]);
            spin += axis * (axis.dot(&momentum) / self.moments[k]);
        }
        spin
    }

    /// The angular momentum of an angular velocity at an orientation [kg·m²/s].
    pub fn momentum(&self, q: [f64; 4], spin: Vec3) -> Vec3 {
        let frame = turned_axes(q);
        let mut momentum = Vec3::zeros();
        for k in 0..3 {
            let axis = to_world(&frame, self.axes[k]);
            momentum += axis * (axis.dot(&spin) * self.moments[k]);
        }
        momentum
    }

    /// The orientation after a time without torque [s].
    pub fn drift(&self, mut q: [f64; 4], momentum: Vec3, dt: f64) -> [f64; 4] {
        let body = to_body(&turned_axes(q), momentum);
        let mut p = to_body(&self.axes, body);
        for (k, share) in [(0, 0.5), (1, 0.5), (2, 1.0), (1, 0.5), (0, 0.5)] {
            let half = 0.5 * share * dt * p[k] / self.moments[k];
            let (sine, cosine) = libm::sincos(half);
            q = turned_within(q, self.axes[k] * sine, cosine);
            // The body turns forward, so that what stands still in the world turns back in it.
            let (s, c) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (p[i], p[j]) = (c * p[i] + s * p[j], c * p[j] - s * p[i]);
        }
        let square = q.iter().fold(0.0, |sum, c| sum + c * c);
        q.map(|c| c * (1.5 - 0.5 * square))
    }
}

/// The orientation `q` after a turn in the body's frame, given as vector and number of a
/// quaternion.
fn turned_within([x, y, z, w]: [f64; 4], v: Vec3, c: f64) -> [f64; 4] {
    [
        w * v.x + x * c + y * v.z - z * v.y,
        w * v.y + y * c + z * v.x - x * v.z,
        w * v.z + z * c + x * v.y - y * v.x,
        w * c - x * v.x - y * v.y - z * v.z,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body whose axes are not those of its frame.
    fn body() -> Inertia {
        let turned = turned_axes([0.1, 0.7, 0.1, 0.7]);
        let axes = turned.map(|axis| axis / axis.norm());
        Inertia { moments: [1.0, 2.0, 3.0], axes }
    }

    /// Largest error of the energy over some turns.
    fn energy_error(dt: f64) -> f64 {
        let (inertia, momentum) = (body(), Vec3::new(0.3, 2.0, 0.5));
        let mut q = [0.0, 0.0, 0.0, 1.0];
        let energy = |q| 0.5 * inertia.spin(q, momentum).dot(&momentum);
        let first = energy(q);
        let mut error = 0.0f64;
        for _ in 0..(50.0 / dt) as usize {
            q = inertia.drift(q, momentum, dt);
            error = error.max((energy(q) / first - 1.0).abs());
        }
        let square: f64 = q.iter().map(|c| c * c).sum();
        assert!((square - 1.0).abs() < 1e-14);
        error
    }

    #[test]
    fn free_rotation_is_of_second_order_and_does_not_drift() {
        let (coarse, fine) = (energy_error(0.02), energy_error(0.01));
        assert!(coarse < 1e-4 && coarse / fine > 3.8 && coarse / fine < 4.2, "{coarse} {fine}");
    }

    #[test]
    fn spin_and_momentum_are_inverse() {
        let (inertia, q, w) = (body(), [0.5, -0.5, 0.5, 0.5], Vec3::new(1.0, -2.0, 0.3));
        assert!((inertia.spin(q, inertia.momentum(q, w)) - w).norm() < 1e-14);
    }

    /// Near its middle axis a body turns over and over. From energy and angular momentum `w1^2` and
    /// `w3^2` are linear in `w2^2`, and Euler's equation for w2 is a quadrature (Landau & Lifshitz,
    /// *Mechanics*, sec. 37).
    #[test]
    fn a_body_flips_with_the_period_of_its_first_integrals() {
        let inertia = Inertia { axes: [Vec3::x(), Vec3::y(), Vec3::z()], ..body() };
        let [i1, i2, i3] = inertia.moments;
        let start = Vec3::new(0.05, 1.0, 0.0);
        let (l2, e2) = (
            (i1 * start.x).powi(2) + (i2 * start.y).powi(2),
            i1 * start.x.powi(2) + i2 * start.y.powi(2),
        );
        // w1^2 and w3^2 are linear in w2^2, so that w2 obeys (dw2/dt)^2 = (a - b w2^2)(c - d w2^2).
        let (a, b) = ((l2 - e2 * i3) / (i1 * (i1 - i3)), i2 * (i2 - i3) / (i1 * (i1 - i3)));
        let (c, d) = ((l2 - e2 * i1) / (i3 * (i3 - i1)), i2 * (i2 - i1) / (i3 * (i3 - i1)));
        let rate = (i3 - i1) / i2;
        let (inner, outer) = ((a / b).min(c / d), (a / b).max(c / d));
        // A quarter: int dx/(rate sqrt(b d (inner - x^2)(outer - x^2))), with x = sqrt(inner)
        // sin(u).
        let n = 20_000;
        let quarter: f64 = (0..n)
            .map(|k| {
                let u = core::f64::consts::FRAC_PI_2 * (k as f64 + 0.5) / f64::from(n);
                1.0 / (rate * (b * d * (outer - inner * u.sin().powi(2))).sqrt())
            })
            .sum::<f64>()
            * core::f64::consts::FRAC_PI_2
            / f64::from(n);
        let (dt, mut q) = (1e-3, [0.0, 0.0, 0.0, 1.0]);
        let momentum = inertia.momentum(q, start);
        let about_second = |q: [f64; 4]| {
            let axes = turned_axes(q);
            inertia.spin(q, momentum).dot(&axes[1])
        };
        let (mut crossings, mut before) = (Vec::new(), about_second(q));
        for step in 1.. {
            q = inertia.drift(q, momentum, dt);
            let now = about_second(q);
            if before * now < 0.0 {
                crossings.push(dt * (f64::from(step) - now / (now - before)));
            }
            before = now;
            if crossings.len() == 3 {
                break;
            }
        }
        let period = crossings[2] - crossings[0];
        assert!((period / (4.0 * quarter) - 1.0).abs() < 1e-5, "{period} {}", 4.0 * quarter);
    }
}
