//! Collisions a second from event to event, and microseconds of a step, of 4,000 spheres: a dilute
//! gas and a dense one, on one thread.
//!
//! `cargo bench -p tremie-grains-hard-sphere --no-default-features --bench collisions`

#[path = "../tests/common/mod.rs"]
mod common;

use common::{bare, gas, make};
use std::time::Instant;
use tremie_grains_hard_sphere::Detection;

fn main() {
    // A face-centred cubic lattice of 10 cells along an edge.
    for phi in [0.05, 0.2618, 0.45] {
        let scene = gas(3, 10, phi, (1.0, 0.0), 1);
        let mut spheres = make(&scene, &bare(Detection::Events), 0.1);
        let n = spheres.sphere_count();
        spheres.advance(100, &[]).expect("a gas");
        let (before, events) = (spheres.diagnostics().collisions, spheres.event_count());
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < 2.0 {
            spheres.advance(10, &[]).expect("a gas");
        }
        let took = start.elapsed().as_secs_f64();
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
        let (start, mut steps) = (Instant::now(), 0);
        while start.elapsed().as_secs_f64() < 2.0 {
            spheres.advance(10, &[]).expect("a gas");
            steps += 10;
        }
        let took = start.elapsed().as_secs_f64();
        println!("{n} spheres at {phi}: {:.0} us a step", 1e6 * took / f64::from(steps));
    }
}
