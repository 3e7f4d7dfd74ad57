//! Million particle-steps per second of a settled bed of spheres with friction 0.5.
//!
//! `cargo bench -p tremie-grains-dem --no-default-features` prints one line for each of three
//! repetitions; `-- SPHERES SKIN` sets another number than 32,000 and another skin than the default.

use std::time::Instant;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
    Scene, Spring,
};

const D: f64 = 1e-3;

/// Height of the bed, in spheres; a tall one would bounce as a whole for long.
const LAYERS: f64 = 8.0;

/// Time in which the packing settles [s].
const SETTLING: f64 = 0.06;

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
    let mut numbers = std::env::args().filter_map(|a| a.parse().ok());
    let scene = bed(numbers.next().unwrap_or(32_000.0));
    let parameters = Parameters { skin: numbers.next(), ..Parameters::default() };
    let dt = parameters.resolve(&scene).expect("a valid scene").time_step.expect("contacts");
    let start = Instant::now();
    let mut dem = GrainsDem::new(&scene, &parameters, dt).expect("a packing");
    println!(
        "packed {} spheres in {:.2?}, time step {dt:.2e} s",
        dem.body_count(),
        start.elapsed()
    );
    dem.advance((SETTLING / dt) as u32, &[]).expect("settling");
    for _ in 0..3 {
        let steps = 300;
        let before = dem.diagnostics().list_rebuilds;
        let start = Instant::now();
        dem.advance(steps, &[]).expect("a settled bed");
        let rate = dem.body_count() as f64 * f64::from(steps) / start.elapsed().as_secs_f64();
        let seen = dem.diagnostics();
        println!(
            "{:.2} million particle-steps/s, {:.2} contacts a sphere, {} list rebuilds, \
             fastest {:.1e} m/s",
            rate * 1e-6,
            seen.contacts as f64 / dem.body_count() as f64,
            seen.list_rebuilds - before,
            seen.max_speed
        );
    }
}
