//! Speed of the solver: millions of cells a second, and nanoseconds a link.
//!
//! `cargo bench -p tremie-fluid-lbm --no-default-features [-- CELLS_PER_EDGE]`

use std::time::Instant;
use tremie_fluid_lbm::{Collision, FluidLbm, Parameters, Precision, Variant};
use tremie_messages::scene::{Domain, Face, FluidMaterial, Scene};
use tremie_messages::{BodyEvent, BodyState, Load};

/// A box of `n` cubed cells of 1 m with a fluid of tau = 0.8.
fn scene(n: usize, face: Face) -> Scene {
    let faces = [0; 3].map(|_| [face.clone(), face.clone()]);
    let fluid = FluidMaterial { velocity: [0.01, 0.0, 0.0], ..FluidMaterial::at_rest(1.0, 0.1) };
    Scene { fluid: Some(fluid), ..Scene::empty(Domain::new([0.0; 3], [n as f64; 3], faces)) }
}

fn fluid(
    n: usize,
    face: Face,
    collision: Collision,
    precision: Precision,
    threads: usize,
    variant: Variant,
    acceleration: f64,
) -> FluidLbm {
    let mut scene = scene(n, face);
    scene.fluid.as_mut().unwrap().acceleration[0] = acceleration;
    let parameters = Parameters { collision, precision, ..Parameters::with_cell(1.0) };
    let time_step = parameters.resolve(&scene).unwrap().time_step;
    FluidLbm::with_variant(&scene, &parameters, time_step, threads, variant).unwrap()
}

/// Seconds of the fastest of a few pairs of steps, halved.
fn seconds_per_step(fluid: &mut FluidLbm, bodies: &mut [BodyState], motion: f64) -> f64 {
    let mut loads = vec![Load::default(); bodies.len()];
    fluid.start(bodies, &mut loads).unwrap();
    let mut best = f64::INFINITY;
    for _ in 0..8 {
        let start = Instant::now();
        for _ in 0..2 {
            for body in &mut *bodies {
                body.position[0] += motion;
            }
            fluid.step(bodies, &mut loads).unwrap();
        }
        best = best.min(0.5 * start.elapsed().as_secs_f64());
    }
    best
}

fn bulk(n: usize, face: Face, acceleration: f64, name: &str) {
    let cells = (n * n * n) as f64;
    for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
        for precision in [Precision::F64, Precision::F32] {
            for collision in [Collision::Bgk, Collision::Trt] {
                for threads in [1, 2] {
                    let mut fluid = fluid(
                        n,
                        face.clone(),
                        collision,
                        precision,
                        threads,
                        variant,
                        acceleration,
                    );
                    let seconds = seconds_per_step(&mut fluid, &mut [], 0.0);
                    println!(
                        "{name:12} {variant:?} {precision:?} {collision:?} {threads} threads: {:7.1} MLUPS",
                        cells / seconds * 1e-6
                    );
                }
            }
        }
    }
}

fn links(n: usize, motion: f64) {
    let mut times = Vec::new();
    let mut count = 0;
    for spheres in [0, 64] {
        let mut fluid =
            fluid(n, Face::Periodic, Collision::Trt, Precision::F64, 1, Variant::widest(), 0.0);
        let pitch = n as f64 / 4.0;
        let mut bodies: Vec<BodyState> = (0..spheres)
            .map(|k| {
                let at = [k % 4, k / 4 % 4, k / 16].map(|k| (f64::from(k) + 0.5) * pitch + 0.123);
                BodyState::at_rest(k as u64, at)
            })
            .collect();
        let events: Vec<BodyEvent> = bodies
            .iter()
            .map(|b| BodyEvent {
                id: b.id,
                kind: BodyEvent::ADDED,
                shape: BodyEvent::SPHERE,
                motion: BodyEvent::FREE,
                set: 0,
                mass: 1.0,
                size: [5.0, 0.0, 0.0],
                table: 0,
            })
            .collect();
        for body in &mut bodies {
            body.velocity[0] = motion;
        }
        fluid.apply_events(&events).unwrap();
        times.push(seconds_per_step(&mut fluid, &mut bodies, motion));
        count = fluid.diagnostics().links;
    }
    println!(
        "64 spheres of 10 cells moving {motion} cells a step: {count} links, {:.1} ns a link",
        (times[1] - times[0]) / count as f64 * 1e9
    );
}

fn main() {
    let n = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(128);
    bulk(n, Face::Periodic, 0.0, "periodic");
    bulk(n, Face::Periodic, 1e-6, "accelerated");
    bulk(n, Face::WALL, 0.0, "walls");
    links(96, 0.0);
    links(96, 0.01);
}
