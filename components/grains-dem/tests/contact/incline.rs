//! A sphere on an inclined plane sticks, slides or rolls as Coulomb says.

use crate::common::*;
use tremie_messages::{
    body::{BodyState, Load},
    scene::{Damping, Motion, Scene},
};

const D: f64 = 1e-3;
const K: f64 = 2e3;
const G: f64 = 9.81;
const DT: f64 = 2e-6;

/// A sphere on the floor z = 0, settled in its overlap, with gravity turned by `angle` towards x.
fn incline(angle: f64, mu: f64) -> Scene {
    let faces = FLOOR;
    let mut scene = scene([1.0, 4e-3, 4e-3], faces, law(K, mu, Damping::Restitution(0.3)));
    scene.gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
    let overlap = mass(D) * G * angle.cos() / K;
    let start = [0.1, 2e-3, 0.5 * D - overlap];
    scene.bodies = vec![set(Motion::Free, vec![sphere(start, D, [0.0; 3])])];
    scene
}

/// Accelerations along x and about y between 10 ms and 30 ms, under a constant torque about y.
fn accelerations(scene: &Scene, torque: f64) -> (f64, f64, BodyState) {
    let load = Load { id: 0, force: [0.0; 3], torque: [0.0, torque, 0.0] };
    let mut dem = make(scene, DT);
    dem.advance(5_000, &[load]).unwrap();
    let early = state(&dem)[0];
    dem.advance(10_000, &[load]).unwrap();
    let late = state(&dem)[0];
    let a = (late.velocity[0] - early.velocity[0]) / (10_000.0 * DT);
    let alpha = (late.angular_velocity[1] - early.angular_velocity[1]) / (10_000.0 * DT);
    (a, alpha, late)
}

/// A torque that balances friction keeps the sphere from rolling: it then is a block.
fn block(angle: f64, mu: f64) -> (f64, f64, BodyState) {
    accelerations(&incline(angle, mu), -mass(D) * G * angle.sin() * 0.5 * D)
}

#[test]
fn a_block_sticks_below_the_angle_of_friction() {
    let (a, _, last) = block(0.499f64.atan(), 0.5);
    assert!(a.abs() < 1e-5 * G, "{a}");
    assert!(last.velocity[0].abs() < 1e-6, "{}", last.velocity[0]);
}

#[test]
fn a_block_slides_above_the_angle_of_friction() {
    for tan in [0.51f64, 0.6, 1.0] {
        let angle = tan.atan();
        let (a, ..) = block(angle, 0.5);
        let expected = G * (angle.sin() - 0.5 * angle.cos());
        assert!((a - expected).abs() < 1e-5 * G, "{a} {expected}");
    }
}

/// Rolling without slip below tan = 7/2 mu; tolerance 1e-4: the lever arm is short by half the
/// overlap, here 3e-6 of the radius, and the start excites a decaying oscillation.
#[test]
fn a_sphere_rolls() {
    for (tan, mu) in [(0.3f64, 0.5), (0.69, 0.2)] {
        let angle = tan.atan();
        let (a, alpha, last) = accelerations(&incline(angle, mu), 0.0);
        let expected = 5.0 / 7.0 * G * angle.sin();
        assert!((a / expected - 1.0).abs() < 1e-4, "{a} {expected}");
        assert!((alpha * 0.5 * D / a - 1.0).abs() < 1e-4);
        let slip = last.velocity[0] - last.angular_velocity[1] * 0.5 * D;
        assert!(slip.abs() < 1e-4 * last.velocity[0], "{slip}");
    }
}

#[test]
fn a_sphere_slips_above_seven_halves_of_friction() {
    let (angle, mu) = (0.8f64.atan(), 0.2);
    let (a, alpha, _) = accelerations(&incline(angle, mu), 0.0);
    let expected = G * (angle.sin() - mu * angle.cos());
    assert!((a / expected - 1.0).abs() < 1e-5, "{a} {expected}");
    let spin = 2.5 * mu * G * angle.cos() / (0.5 * D);
    assert!((alpha / spin - 1.0).abs() < 1e-4, "{alpha} {spin}");
}
