//! The grains by themselves: a bed of spheres with friction that has settled.

use crate::math::parameters::Parameters;
use crate::solver::dem_solver::GrainsDem;
use std::f64::consts::PI;
use std::time::Instant;
use tremie_messages::body::BodyState;
use tremie_messages::scene::{
    BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw, Placement,
    Scene, Sphere, Spring,
};
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Measurement, Quantity};

const D: f64 = 1e-3;
/// Height of the bed, in spheres; a tall one would bounce as a whole for long.
const LAYERS: f64 = 8.0;
/// Spheres of the bed that settles; larger ones are put together of it.
const TILE: f64 = 8e3;
/// Time in which the packing settles for the most part [s].
const SETTLING: f64 = 0.02;

/// Beds: one that a processor's caches hold, and one that they do not.
pub fn benchmarks(sizes: &BenchmarkSizes) -> Vec<Benchmark> {
    let beds = [(2, "32,000"), (5, "200,000")];
    beds.iter().flat_map(|bed| sizes.threads.iter().map(|&threads| of_bed(*bed, threads))).collect()
}

fn of_bed((copies, spheres): (usize, &str), threads: usize) -> Benchmark {
    let make = move || {
        let (scene, step) = bed(copies)?;
        let mut bed = GrainsDem::new(&scene, &Parameters::default(), step, threads)
            .map_err(|problems| format!("{problems:?}"))?;
        let measure: Measurement = Box::new(move |seconds| {
            let (start, mut substeps) = (Instant::now(), 0);
            while substeps == 0 || start.elapsed().as_secs_f64() < seconds {
                bed.advance(50, &[]).map_err(|error| error.to_string())?;
                substeps += 50;
            }
            let spent = start.elapsed().as_secs_f64();
            Ok(vec![1e-6 * bed.body_count() as f64 * f64::from(substeps) / spent])
        });
        Ok(measure)
    };
    Benchmark {
        name: format!("grains, bed of {spheres} spheres with friction"),
        threads,
        quantities: vec![Quantity::new("", "million sphere-substeps/s")],
        make: Box::new(make),
    }
}

/// A bed that has settled, beside itself `copies` times `copies` times, and its time step [s].
fn bed(copies: usize) -> Result<(Scene, f64), String> {
    let (mut scene, parameters) = (tile(), Parameters::default());
    let said = |problems: Vec<tremie_messages::Problem>| format!("{problems:?}");
    let step = parameters.resolve(&scene).map_err(said)?.time_step.ok_or("no contacts")?;
    let mut tile = GrainsDem::new(&scene, &parameters, step, 1).map_err(said)?;
    tile.advance((SETTLING / step) as u32, &[]).map_err(|error| error.to_string())?;
    let mut states = vec![BodyState::at_rest(0, [0.0; 3]); tile.body_count()];
    tile.write_state(&mut states);
    let [x, y, _] = scene.domain.size();
    let mut spheres = Vec::with_capacity(copies * copies * states.len());
    for copy in 0..copies * copies {
        let shift = [(copy % copies) as f64 * x, (copy / copies) as f64 * y, 0.0];
        spheres.extend(states.iter().zip(tile.radii()).map(|(state, radius)| Sphere {
            position: std::array::from_fn(|a| state.position[a] + shift[a]),
            diameter: 2.0 * radius,
            velocity: state.velocity,
            angular_velocity: state.angular_velocity,
        }));
    }
    scene.domain.max[0] = copies as f64 * x;
    scene.domain.max[1] = copies as f64 * y;
    scene.bodies[0].placement = Placement::Listed(spheres);
    Ok((scene, step))
}

/// A packing on a floor between periodic sides.
fn tile() -> Scene {
    let side = (TILE / LAYERS).sqrt() * D;
    let fraction = 0.55;
    let height = TILE * PI / 6.0 * D.powi(3) / (fraction * side * side);
    let law = ContactLaw {
        spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 800.0 },
        friction: 0.5,
        rolling_friction: 0.0,
        damping: Damping::Restitution(0.5),
        tension: false,
    };
    let periodic = [Face::Periodic, Face::Periodic];
    let faces = [periodic.clone(), periodic, [Face::WALL, Face::WALL]];
    let between = |other: &str| PairLaw { between: ["bed".into(), other.into()], law: law.clone() };
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
        contacts: ["bed", "wall"].map(between).to_vec(),
        ..Scene::empty(Domain::new([0.0; 3], [side, side, 1.2 * height], faces))
    }
}
