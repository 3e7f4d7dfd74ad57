//! A spinning sphere set on a plane slips, then rolls at 2/7 R w (tolerance 1e-3).

use crate::common::*;
use tremie_messages::scene::{Damping, Motion};

#[test]
fn ends_rolling_at_two_sevenths() {
    let (d, w, k) = (1e-3, 100.0, 1e3);
    let faces = FLOOR;
    let mut scene = scene([0.01; 3], faces, law(k, 0.5, Damping::Restitution(0.5)));
    scene.gravity = [0.0, 0.0, -9.81];
    let mut spinning = sphere([5e-3, 5e-3, 0.5 * d + 1e-6], d, [0.0; 3]);
    spinning.angular_velocity = [0.0, w, 0.0];
    scene.bodies = vec![set(Motion::Free, vec![spinning])];
    let mut dem = make(&scene, 2e-6);
    dem.advance(20_000, &[]).unwrap();
    let last = state(&dem)[0];
    let expected = 2.0 / 7.0 * 0.5 * d * w;
    assert!((last.velocity[0] / expected - 1.0).abs() < 1e-3, "{}", last.velocity[0]);
    let slip = last.velocity[0] - last.angular_velocity[1] * 0.5 * d;
    assert!(slip.abs() < 1e-4 * expected, "{slip}");
    assert!(last.velocity[1].abs() < 1e-12);
}
