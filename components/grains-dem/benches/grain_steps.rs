//! Million particle-steps per second of a settled bed of spheres with friction 0.5, on one thread and
//! on two, from 1e4 to 1e6 spheres, and the cost of a sphere and substep over that in the smallest
//! bed. On one thread the processor's time counts, on two the clock's.
//!
//! `cargo bench -p tremie-grains-dem --no-default-features`; `-- SPHERES SKIN` measures one other
//! number of spheres, and another skin than the default.

use std::time::Instant;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
    Scene, Spring,
};

const D: f64 = 1e-3;

/// Height of the bed, in spheres; a tall one would bounce as a whole for long.
const LAYERS: f64 = 8.0;

/// Time in which the packing settles for the most part [s].
const SETTLING: f64 = 0.01;

fn bed(spheres: f64) -> Scene {
    let side = (spheres / LAYERS).sqrt() * D;
    let fraction = 0.55;
    let height = spheres * std::f64::consts::PI / 6.0 * D.powi(3) / (fraction * side * side);
    let law = ContactLaw {
        spring: Spring::Linear { normal_stiffness: 100.0, tangential_stiffness: 80.0 },
        friction: 0.5,
        rolling_friction: 0.0,
        damping: Damping::Restitution(0.5),
        tension: false,
    };
    Scene {
        gravity: [0.0, 0.0, -9.81],
        bodies: vec![BodySet {
            name: "bed".into(),
            density: 2500.0,
            material: "bed".into(),
            motion: Motion::Free,
            placement: Placement::Packed(Packing {
                min: [0.0; 3],
                max: [side, side, height],
                fraction,
                diameters: Diameters::Uniform { min: 0.95 * D, max: 1.05 * D },
                seed: 1,
            }),
        }],
        contacts: ["bed", "wall"]
            .map(|other| PairLaw { between: ["bed".into(), other.into()], law: law.clone() })
            .to_vec(),
        ..Scene::empty(Domain::new(
            [0.0; 3],
            [side, side, 1.2 * height],
            [
                [Face::Periodic, Face::Periodic],
                [Face::Periodic, Face::Periodic],
                [Face::WALL, Face::WALL],
            ],
        ))
    }
}

fn main() {
    let numbers: Vec<f64> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let sizes = match numbers.first() {
        Some(&spheres) => vec![spheres],
        None => vec![1e4, 3.2e4, 1.92e5, 1e6],
    };
    let parameters = Parameters { skin: numbers.get(1).copied(), ..Parameters::default() };
    let mut first = None;
    for spheres in sizes {
        let [one, _] = [1, 2].map(|threads| measure(spheres, &parameters, threads));
        let first = *first.get_or_insert(one);
        println!("cost of a sphere and substep: {:.2} of that in the smallest bed", first / one);
    }
}

/// The best of three repetitions, in million particle-steps per second.
fn measure(spheres: f64, parameters: &Parameters, threads: usize) -> f64 {
    let scene = bed(spheres);
    let dt = parameters.resolve(&scene).expect("a valid scene").time_step.expect("contacts");
    let mut dem = GrainsDem::new(&scene, parameters, dt, threads).expect("a packing");
    dem.advance((SETTLING / dt) as u32, &[]).expect("settling");
    let mut best = 0.0f64;
    let steps = (3e6 / spheres) as u32;
    let before = dem.diagnostics().list_rebuilds;
    for _ in 0..3 {
        let (start, busy) = (Instant::now(), busy());
        dem.advance(steps, &[]).expect("a settled bed");
        let took = match (threads, busy) {
            (1, Some(before)) => self::busy().unwrap_or(f64::NAN) - before,
            _ => start.elapsed().as_secs_f64(),
        };
        let rate = dem.body_count() as f64 * f64::from(steps) / took;
        best = best.max(rate * 1e-6);
    }
    let seen = dem.diagnostics();
    println!(
        "{} spheres, {threads} threads: {best:.2} million particle-steps/s; {:.2} contacts a \
         sphere, {} list rebuilds, fastest {:.1e} m/s",
        dem.body_count(),
        seen.contacts as f64 / dem.body_count() as f64,
        seen.list_rebuilds - before,
        seen.max_speed
    );
    best
}

/// Processor time of the main thread [s], where the system tells: other programs do not enter it.
fn busy() -> Option<f64> {
    let times = std::fs::read_to_string("/proc/self/schedstat").ok()?;
    Some(times.split_whitespace().next()?.parse::<f64>().ok()? * 1e-9)
}
