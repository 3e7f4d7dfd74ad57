//! The integrator is second order, dashpots included, as long as a contact lasts.

use crate::common::*;
use tremie_grains_dem::{GrainsDem, Integrator, Parameters};
use tremie_messages::scene::{ContactLaw, Damping, Motion};

const D: f64 = 1e-3;
const K: f64 = 1e3;
const G: f64 = 9.81;

/// Height over the position at rest after a time of about four periods, and the exact one.
fn bounce(dt: f64, steps: u32) -> (f64, f64) {
    let zeta = 0.1;
    let omega = (K / mass(D)).sqrt();
    let gamma = 2.0 * zeta * (K * mass(D)).sqrt();
    let mut scene = scene([4e-3; 3], WALLS, law(K, 0.0, coefficients(gamma, 0.0)));
    scene.gravity = [0.0, 0.0, -G];
    let rest = 0.5 * D - mass(D) * G / K;
    let amplitude = -0.5 * mass(D) * G / K;
    let start = [2e-3, 2e-3, rest + amplitude];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0; 3])])];
    let mut dem = make(&scene, dt);
    dem.advance(steps, &[]).unwrap();
    let t = dt * f64::from(steps);
    let w = omega * (1.0 - zeta * zeta).sqrt();
    let decay = (-zeta * omega * t).exp();
    let exact = amplitude * decay * ((w * t).cos() + zeta * omega / w * (w * t).sin());
    (((state(&dem)[0].position[2] - rest) - exact) / amplitude, t)
}

#[test]
fn normal_spring_and_dashpot() {
    let period = std::f64::consts::TAU * (mass(D) / K).sqrt();
    let errors = [20, 40, 80].map(|n| bounce(period / f64::from(n), 4 * n).0.abs());
    println!("errors {errors:?}");
    assert!(errors[0] < 0.1);
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.8..2.3).contains(&order), "{errors:?}: {order}");
    }
}

/// Positions and spins (times the diameter) of a sphere that sticks to the floor and swings in its
/// tangential spring, 20 times.
fn swing(steps: u32, integrator: Integrator) -> Vec<[f64; 2]> {
    let faces = FLOOR;
    let sticky = ContactLaw { friction: 1e3, ..law(K, 0.0, Damping::Restitution(0.8)) };
    let mut scene = scene([4e-3; 3], faces, sticky);
    scene.gravity = [0.3, 0.0, -G];
    let start = [2e-3, 2e-3, 0.5 * D - mass(D) * G / K];
    let mut pushed = sphere(start, D, [0.0; 3]);
    pushed.angular_velocity = [0.0, 0.5, 0.0];
    scene.bodies = vec![set(Motion::Free, vec![pushed])];
    let parameters = Parameters { integrator, ..Parameters::default() };
    let mut dem = GrainsDem::new(&scene, &parameters, 2e-5 / f64::from(steps), 1).unwrap();
    let sample = |_| {
        dem.advance(steps, &[]).unwrap();
        let now = state(&dem)[0];
        [now.position[0], now.angular_velocity[1] * D]
    };
    (0..20).map(sample).collect()
}

/// Checks that an integrator is second order in the tangential spring and dashpot.
pub fn is_second_order_across(integrator: Integrator) {
    let [a, b, c] = [4, 8, 16].map(|steps| swing(steps, integrator));
    for q in 0..2 {
        let distance = |a: &[[f64; 2]], b: &[[f64; 2]]| {
            a.iter().zip(b).map(|(a, b)| (a[q] - b[q]).powi(2)).sum::<f64>().sqrt()
        };
        let order = (distance(&a, &b) / distance(&b, &c)).log2();
        println!("quantity {q}: order {order}");
        assert!((1.8..2.3).contains(&order), "{order}");
    }
}

#[test]
fn tangential_spring_and_dashpot() {
    is_second_order_across(Integrator::Verlet);
}
