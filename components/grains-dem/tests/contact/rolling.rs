//! Rolling friction holds a sphere on a slope, and brakes one that rolls.

use crate::common::*;
use tremie_messages::{
    body::BodyState,
    scene::{ContactLaw, Damping, Motion},
};

const D: f64 = 1e-3;
const G: f64 = 9.81;
const MU_R: f64 = 0.1;
const DT: f64 = 2e-6;

/// A sphere on a slope, rolling down at `speed` at first, after `steps` and after twice as many.
fn roll(slope: f64, speed: f64, steps: u32) -> [BodyState; 2] {
    let law = ContactLaw { rolling_friction: MU_R, ..law(2e3, 0.5, Damping::Restitution(0.5)) };
    let mut scene = scene([1.0, 4e-3, 4e-3], FLOOR, law);
    scene.gravity = [G * slope.sin(), 0.0, -G * slope.cos()];
    let overlap = mass(D) * G * slope.cos() / 2e3;
    let mut rolling = sphere([0.1, 2e-3, 0.5 * D - overlap], D, [speed, 0.0, 0.0]);
    rolling.angular_velocity = [0.0, 2.0 * speed / D, 0.0];
    scene.bodies = vec![set(Motion::Free, vec![rolling])];
    let mut dem = make(&scene, DT);
    [0; 2].map(|_| {
        dem.advance(steps, &[]).unwrap();
        state(&dem)[0]
    })
}

#[test]
fn a_sphere_stands_below_the_angle_of_rolling_friction() {
    let [early, late] = roll((0.95 * MU_R).atan(), 0.0, 20_000);
    assert!(norm(late.velocity) < 1e-7, "{late:?}");
    assert!(norm(minus(late.position, early.position)) < 1e-9);
}

/// `a = 5/7 g (sin - mu_r cos)` while it rolls without slip; within 0.1 %.
#[test]
fn rolling_friction_brakes() {
    for (slope, speed) in [(0.0, 0.2), (0.3f64.atan(), 0.0)] {
        let steps = 8_000;
        let [early, late] = roll(slope, speed, steps);
        let a = (late.velocity[0] - early.velocity[0]) / (DT * f64::from(steps));
        let expected = 5.0 / 7.0 * G * (slope.sin() - MU_R * slope.cos());
        assert!((a / expected - 1.0).abs() < 1e-3, "{a} {expected}");
    }
}

/// The loss on the way to rest is the work of friction, no more: it stops in `v^2/(2 a)`.
#[test]
fn a_rolling_sphere_stops_and_stays() {
    let speed = 0.05;
    let [early, late] = roll(0.0, speed, 60_000);
    let way = speed * speed / (2.0 * 5.0 / 7.0 * G * MU_R);
    assert!(((early.position[0] - 0.1) / way - 1.0).abs() < 1e-2, "{early:?} {way}");
    assert!(norm(late.velocity) < 1e-7 && norm(minus(late.position, early.position)) < 1e-8);
}
