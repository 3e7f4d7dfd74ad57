//! Collisions a second from event to event, and microseconds of a step, of 4,000 spheres, both of processor time: a dilute
//! gas and a dense one, on one thread.
//!
//! `cargo bench -p tremie-grains-hard-sphere --no-default-features --bench collisions`

#[path = "../tests/common/mod.rs"]
mod common;

use common::{bare, gas, make};
use tremie_grains_hard_sphere::Detection;
use tremie_test_support::processor_seconds;

fn main() {
    // A face-centred cubic lattice of 10 cells along an edge.
    for phi in [0.05, 0.2618, 0.45] {
        let scene = gas(3, 10, phi, (1.0, 0.0), 1);
        let mut spheres = make(&scene, &bare(Detection::Events), 0.1);
        let n = spheres.sphere_count();
        spheres.advance(100, &[]).expect("a gas");
        let (before, events) = (spheres.diagnostics().collisions, spheres.event_count());
        let start = processor_seconds();
        while processor_seconds() - start < 1.0 {
            spheres.advance(10, &[]).expect("a gas");
        }
        let took = processor_seconds() - start;
        let collisions = (spheres.diagnostics().collisions - before) as f64;
        let events = (spheres.event_count() - events) as f64;
        println!(
            "{n} spheres at {phi}: {:.3} million collisions/s, {:.2} events a collision",
            1e-6 * collisions / took,
            events / collisions
        );
        // A step of a tenth of the radius at the mean speed.
        let step = 0.05 / 1.6;
        let mut spheres = make(&scene, &bare(Detection::Steps), step);
        spheres.advance(100, &[]).expect("a gas");
        let (start, mut steps) = (processor_seconds(), 0);
        while processor_seconds() - start < 1.0 {
            spheres.advance(10, &[]).expect("a gas");
            steps += 10;
        }
        let took = processor_seconds() - start;
        println!("{n} spheres at {phi}: {:.0} us a step", 1e6 * took / f64::from(steps));
    }
}
