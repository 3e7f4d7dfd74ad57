//! What steps miss: pairs that touch and part within one.

use crate::common::{bare, gas, make};
use tremie_grains_hard_sphere::Detection;

/// Of an elastic gas at `dt = 0.1` the part `(2/3) T dt²` in space and `(1/4) T dt²` in a plane is
/// missed. Such pairs are grazing, and a step that misses one finds the same partner less often
/// again: so the rate is compared with one from event to event, over long times.
#[test]
fn the_rate_falls_by_what_theory_says() {
    for (dimensions, edge, share) in [(3, 8, 2.0 / 3.0), (2, 32, 0.25)] {
        let (phi, dt) = (0.1, [0.1, 0.2][usize::from(dimensions == 2)]);
        let scene = gas(dimensions, edge, phi, (1.0, 0.0), 3);
        let rate = |detection: Detection| {
            let mut gas = make(&scene, &bare(detection), dt);
            gas.advance(100, &[]).unwrap();
            let before = gas.diagnostics().collisions;
            let time = 4000;
            gas.advance(time, &[]).unwrap();
            (gas.diagnostics().collisions - before) as f64
        };
        let (events, steps) = (rate(Detection::Events), rate(Detection::Steps));
        let missed = 1.0 - steps / events;
        let expected = share * dt * dt;
        println!("{dimensions}-D, {events} collisions: {missed:.5} missed, expected {expected:.5}");
        assert!((missed / expected - 1.0).abs() < 0.1, "{dimensions}-D: {missed} {expected}");
    }
}
