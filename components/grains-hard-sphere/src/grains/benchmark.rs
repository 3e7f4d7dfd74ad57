//! The hard spheres by themselves: a dilute gas of 4,000 spheres.

use crate::grains::hard_spheres::HardSpheres;
use crate::setup::parameters::{Detection, Parameters};
use core::f64::consts::PI;
use std::time::Instant;
use tremie_grains_kit::math::random::Random;
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Domain, Face, Motion, PairLaw, Placement, Scene, Sphere, Spring,
};
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Measurement, Quantity};

/// Spheres along an edge of the lattice on which they begin.
const EDGE: usize = 16;
/// Solid fraction.
const FRACTION: f64 = 0.05;

/// From event to event, which is one thread's work, and from step to step.
pub fn benchmarks(sizes: &BenchmarkSizes) -> Vec<Benchmark> {
    let steps = sizes.threads.iter().map(|&threads| from_step_to_step(threads));
    core::iter::once(from_event_to_event()).chain(steps).collect()
}

fn from_event_to_event() -> Benchmark {
    let make = || {
        let mut gas = spheres(Detection::Events, 1)?;
        let measure: Measurement = Box::new(move |seconds| {
            let (start, before) = (Instant::now(), gas.diagnostics().collisions);
            while start.elapsed().as_secs_f64() < seconds {
                gas.advance(20, &[]).map_err(|error| error.to_string())?;
            }
            let spent = start.elapsed().as_secs_f64();
            Ok(vec![1e-6 * (gas.diagnostics().collisions - before) as f64 / spent])
        });
        Ok(measure)
    };
    Benchmark {
        name: "hard spheres, 4,096 at a fraction of 0.05, from event to event".into(),
        threads: 1,
        quantities: vec![Quantity::new("", "million collisions/s")],
        make: Box::new(make),
    }
}

fn from_step_to_step(threads: usize) -> Benchmark {
    let make = move || {
        let mut gas = spheres(Detection::Steps, threads)?;
        let measure: Measurement = Box::new(move |seconds| {
            let (start, mut steps) = (Instant::now(), 0u32);
            while steps == 0 || start.elapsed().as_secs_f64() < seconds {
                gas.advance(20, &[]).map_err(|error| error.to_string())?;
                steps += 20;
            }
            let spent = start.elapsed().as_secs_f64();
            Ok(vec![1e-6 * gas.body_count() as f64 * f64::from(steps) / spent])
        });
        Ok(measure)
    };
    Benchmark {
        name: "hard spheres, 4,096 at a fraction of 0.05, from step to step".into(),
        threads,
        quantities: vec![Quantity::new("", "million sphere-steps/s")],
        make: Box::new(make),
    }
}

/// A dilute gas whose steps take a sphere a twentieth of its radius.
fn spheres(detection: Detection, threads: usize) -> Result<HardSpheres, String> {
    let parameters = Parameters { detection, ..Parameters::default() };
    let step = 0.05 * 0.5 * 1e-3;
    HardSpheres::new(&gas(), &parameters, step, threads).map_err(|problems| format!("{problems:?}"))
}

/// Smooth elastic spheres of 1 mm, periodic, at about 1 m/s.
fn gas() -> Scene {
    let d = 1e-3;
    let count = EDGE * EDGE * EDGE;
    let spacing = d * libm::cbrt(PI / 6.0 / FRACTION);
    let sphere = |k: usize| {
        let place = [k % EDGE, k / EDGE % EDGE, k / (EDGE * EDGE)];
        let mut random = Random::new(1, k as u64);
        Sphere {
            position: place.map(|n| spacing * (n as f64 + 0.5)),
            diameter: d,
            velocity: [(); 3].map(|()| 2.0 * random.unit() - 1.0),
            angular_velocity: [0.0; 3],
        }
    };
    let law = ContactLaw {
        spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 8e2 },
        friction: 0.0,
        rolling_friction: 0.0,
        damping: Damping::Restitution(1.0),
        tension: false,
    };
    let faces = [(); 3].map(|()| [Face::Periodic, Face::Periodic]);
    Scene {
        contacts: vec![PairLaw { between: ["gas".into(), "gas".into()], law }],
        bodies: vec![BodySet {
            name: "gas".into(),
            density: 2500.0,
            material: "gas".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed((0..count).map(sphere).collect()),
        }],
        ..Scene::empty(Domain::new([0.0; 3], [EDGE as f64 * spacing; 3], faces))
    }
}
