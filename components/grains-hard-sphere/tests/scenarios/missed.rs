//! What steps miss: pairs that touch and part within one.

use crate::common::{bare, density, gas, make, set, sphere};
use tremie_grains_hard_sphere::{Detection, HardSpheres};
use tremie_messages::scene::{Motion, Scene};

/// The scene with its bodies where a run has brought them.
fn as_it_is(scene: &Scene, spheres: &HardSpheres, dimensions: usize) -> Scene {
    let now = |id: usize| {
        let state = spheres.sphere(id);
        sphere(state.position, 1.0, state.velocity)
    };
    let bodies = (0..spheres.sphere_count()).map(now).collect();
    Scene { bodies: vec![set(Motion::Free, density(dimensions), bodies)], ..scene.clone() }
}

/// Of an elastic gas at `dt = 0.1` the part `(2/3) T dt²` of the collisions is missed in space, and
/// `(1/4) T dt²` in a plane. A gas goes from event to event; from each of its states one step is
/// made, and both count their collisions.
#[test]
fn a_step_misses_what_theory_says() {
    for (dimensions, edge, phi, share, windows) in
        [(3, 8, 0.1, 2.0 / 3.0, 600), (2, 32, 0.2, 0.25, 2400)]
    {
        let (scene, dt) = (gas(dimensions, edge, phi, (1.0, 0.0), 3), 0.1);
        let mut events = make(&scene, &bare(Detection::Events), dt);
        events.advance(100, &[]).unwrap();
        let (before, mut by_steps) = (events.diagnostics().collisions, 0);
        for _ in 0..windows {
            let now = as_it_is(&scene, &events, dimensions);
            let mut step = make(&now, &bare(Detection::Steps), dt);
            step.advance(1, &[]).unwrap();
            by_steps += step.diagnostics().collisions;
            events.advance(1, &[]).unwrap();
        }
        let all = (events.diagnostics().collisions - before) as f64;
        let (missed, expected) = (1.0 - by_steps as f64 / all, share * dt * dt);
        let percent = 100.0 * (missed / expected - 1.0);
        println!("{dimensions}-D, {all} collisions: {missed:.5} missed, {percent:.1} % off");
        assert!(percent.abs() < 10.0, "{dimensions}-D: {missed} {expected}");
    }
}
