//! Million particle-steps per second of a settled bed of spheres with friction 0.5, on one thread and
//! on two: one bed of 8,000, and 4, 25 and 121 of it side by side, so that all have the same contacts.
//! On one thread the processor's time counts, on two the clock's.
//!
//! `cargo bench -p tremie-grains-dem --no-default-features`; `-- COPIES SKIN` measures COPIES times
//! COPIES beds, and another skin than the default.

use std::time::Instant;
use tremie_grains_dem::{GrainsDem, Parameters};
use tremie_messages::body::BodyState;
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
    Scene, Sphere, Spring,
};
use tremie_test_support::processor_seconds;

const D: f64 = 1e-3;

/// Height of the bed, in spheres; a tall one would bounce as a whole for long.
const LAYERS: f64 = 8.0;

/// Time in which the packing settles for the most part [s].
const SETTLING: f64 = 0.02;

/// Particle-steps of a repetition.
const STEPS: f64 = 6e6;

fn bed(spheres: f64) -> Scene {
    let side = (spheres / LAYERS).sqrt() * D;
    let fraction = 0.55;
    let height = spheres * std::f64::consts::PI / 6.0 * D.powi(3) / (fraction * side * side);
    let law = ContactLaw {
        spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 800.0 },
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
            clump: None,
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
    let copies = match numbers.first() {
        Some(&copies) => vec![copies as usize],
        None => vec![1, 2, 5, 11],
    };
    let parameters = Parameters { skin: numbers.get(1).copied(), ..Parameters::default() };
    let one = bed(8e3);
    let dt = parameters.resolve(&one).expect("a valid scene").time_step.expect("contacts");
    let mut settled = GrainsDem::new(&one, &parameters, dt, 2).expect("a packing");
    settled.advance((SETTLING / dt) as u32, &[]).expect("settling");
    let mut first = None;
    for copies in copies {
        let scene = tiled(&one, &settled, copies);
        let [rate, _] = [1, 2].map(|threads| measure(&scene, &parameters, dt, threads));
        let first = *first.get_or_insert(rate);
        println!("cost of a sphere and substep: {:.2} of that in the first bed", first / rate);
    }
}

/// The settled bed, side by side `copies` times `copies` times.
fn tiled(one: &Scene, settled: &GrainsDem, copies: usize) -> Scene {
    let mut states = vec![BodyState::at_rest(0, [0.0; 3]); settled.body_count()];
    settled.write_state(&mut states);
    let [x, y, _] = one.domain.size();
    let mut spheres = Vec::with_capacity(copies * copies * states.len());
    for copy in 0..copies * copies {
        let (i, k) = ((copy % copies) as f64, (copy / copies) as f64);
        spheres.extend(states.iter().zip(settled.radii()).map(|(state, radius)| Sphere {
            position: [state.position[0] + i * x, state.position[1] + k * y, state.position[2]],
            diameter: 2.0 * radius,
            velocity: state.velocity,
            angular_velocity: state.angular_velocity,
        }));
    }
    let mut scene = one.clone();
    scene.domain.max[0] = copies as f64 * x;
    scene.domain.max[1] = copies as f64 * y;
    scene.bodies[0].placement = Placement::Listed(spheres);
    scene
}

/// The best of three repetitions, in million particle-steps per second.
fn measure(scene: &Scene, parameters: &Parameters, dt: f64, threads: usize) -> f64 {
    let mut dem = GrainsDem::new(scene, parameters, dt, threads).expect("a packing");
    let mut best = 0.0f64;
    let steps = (STEPS / dem.body_count() as f64) as u32;
    dem.advance(steps / 4, &[]).expect("a settled bed");
    let before = dem.diagnostics().list_rebuilds;
    for _ in 0..3 {
        let (start, busy) = (Instant::now(), processor_seconds());
        dem.advance(steps, &[]).expect("a settled bed");
        let took = match threads {
            1 => processor_seconds() - busy,
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
