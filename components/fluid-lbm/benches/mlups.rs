//! Speed of the solver: millions of cells a second, and nanoseconds a link.
//!
//! `cargo bench -p tremie-fluid-lbm --no-default-features [-- [CELLS_PER_EDGE] [WORD ...]]` runs
//! the cases whose names have all the words.

use std::time::Instant;
use tremie_fluid_lbm::{Collision, LbmFluid, Parameters, Precision, Variant, Walls};
use tremie_messages::scene::{
    Domain, Face, FluidMaterial, Geometry, Motion, Part, PartBoundary, Pose, Scene,
};
use tremie_messages::{BodyEvent, BodyState, Load};
use tremie_test_support::processor_seconds;

/// A box of `n` cubed cells of 1 m with a fluid of tau = 0.8.
fn scene(n: usize, face: Face) -> Scene {
    let faces = [0; 3].map(|_| [face.clone(), face.clone()]);
    let fluid = FluidMaterial { velocity: [0.01, 0.0, 0.0], ..FluidMaterial::at_rest(1.0, 0.1) };
    Scene { fluid: Some(fluid), ..Scene::empty(Domain::new([0.0; 3], [n as f64; 3], faces)) }
}

#[expect(clippy::too_many_arguments, reason = "each is a column of the table")]
fn fluid(
    n: usize,
    face: Face,
    collision: Collision,
    precision: Precision,
    threads: usize,
    variant: Variant,
    acceleration: f64,
    smagorinsky: f64,
) -> LbmFluid {
    let mut scene = scene(n, face);
    scene.fluid.as_mut().unwrap().acceleration[0] = acceleration;
    let parameters = Parameters { collision, precision, smagorinsky, ..Parameters::with_cell(1.0) };
    let time_step = parameters.resolve(&scene).unwrap().time_step;
    LbmFluid::with_variant(&scene, &parameters, time_step, threads, variant).unwrap()
}

/// Seconds of the fastest of a few pairs of steps, halved: of the processor for one thread, else of
/// the clock.
fn seconds_per_step(
    fluid: &mut LbmFluid,
    bodies: &mut [BodyState],
    motion: f64,
    threads: usize,
) -> f64 {
    let mut loads = vec![Load::default(); bodies.len()];
    fluid.start(bodies, &mut loads).unwrap();
    let mut best = f64::INFINITY;
    for _ in 0..20 {
        let start = Instant::now();
        let busy = processor_seconds();
        for _ in 0..2 {
            for body in &mut *bodies {
                body.position[0] += motion;
            }
            fluid.step(bodies, &mut loads).unwrap();
        }
        let spent =
            if threads == 1 { processor_seconds() - busy } else { start.elapsed().as_secs_f64() };
        best = best.min(0.5 * spent);
    }
    best
}

/// True if the command line asks for a case.
fn wanted(case: &str) -> bool {
    let words = std::env::args().skip(1).filter(|a| a.parse::<usize>().is_err() && a != "--bench");
    words.into_iter().all(|word| case.contains(&word))
}

fn bulk(n: usize, face: Face, acceleration: f64, smagorinsky: f64, name: &str) {
    let cells = (n * n * n) as f64;
    for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
        for precision in [Precision::F64, Precision::F32] {
            for collision in [Collision::Bgk, Collision::Trt] {
                for threads in [1, 2] {
                    let case = format!(
                        "{name:12} {variant:?} {precision:?} {collision:?} {threads} threads"
                    );
                    if !wanted(&case) {
                        continue;
                    }
                    let mut fluid = fluid(
                        n,
                        face.clone(),
                        collision,
                        precision,
                        threads,
                        variant,
                        acceleration,
                        smagorinsky,
                    );
                    let seconds = seconds_per_step(&mut fluid, &mut [], 0.0, threads);
                    println!("{case}: {:7.1} MLUPS", cells / seconds * 1e-6);
                }
            }
        }
    }
}

/// A bore and the bolt in it, 44 % of the box: millions of fluid cells a second.
fn bore(n: usize) {
    for precision in [Precision::F64, Precision::F32] {
        for walls in [Walls::Bouzidi, Walls::Halfway] {
            for smagorinsky in [0.0, 0.1] {
                for threads in [1, 2] {
                    let case =
                        format!("bore {precision:?} {walls:?} C {smagorinsky} {threads} threads");
                    if !wanted(&case) {
                        continue;
                    }
                    let mut scene = scene(n, Face::WALL);
                    let size = n as f64;
                    for (name, radius, cavity) in [("bore", 0.4375, true), ("bolt", 0.219, false)] {
                        scene.parts.push(Part {
                            name: name.into(),
                            geometry: Geometry::Cylinder {
                                radius: radius * size,
                                length: 3.0 * size,
                            },
                            pose: Pose { position: [0.501 * size; 3], ..Pose::IDENTITY },
                            cavity,
                            material: "wall".into(),
                            motion: Motion::Fixed,
                            boundary: PartBoundary::Wall,
                        });
                    }
                    let collision = Collision::Bgk;
                    let parameters = Parameters {
                        collision,
                        precision,
                        smagorinsky,
                        walls,
                        ..Parameters::with_cell(1.0)
                    };
                    let time_step = parameters.resolve(&scene).unwrap().time_step;
                    let mut fluid = LbmFluid::new(&scene, &parameters, time_step, threads).unwrap();
                    let seconds = seconds_per_step(&mut fluid, &mut [], 0.0, threads);
                    let cells = fluid.diagnostics().fluid_cells as f64;
                    println!(
                        "{case}: {:7.1} MLUPS, {:.1} bytes a cell",
                        cells / seconds * 1e-6,
                        fluid.memory_bytes() as f64 / cells
                    );
                }
            }
        }
    }
}

fn links(n: usize, motion: f64) {
    if !wanted("links") {
        return;
    }
    let mut times = Vec::new();
    let mut count = 0;
    for spheres in [0, 64] {
        let mut fluid = fluid(
            n,
            Face::Periodic,
            Collision::Trt,
            Precision::F64,
            1,
            Variant::widest(),
            0.0,
            0.0,
        );
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
        times.push(seconds_per_step(&mut fluid, &mut bodies, motion, 1));
        count = fluid.diagnostics().links;
    }
    println!(
        "64 spheres of 10 cells moving {motion} cells a step: {count} links, {:.1} ns a link",
        (times[1] - times[0]) / count as f64 * 1e9
    );
}

fn main() {
    let n = std::env::args().filter_map(|a| a.parse().ok()).next().unwrap_or(128);
    bulk(n, Face::Periodic, 0.0, 0.0, "periodic");
    bulk(n, Face::Periodic, 1e-6, 0.0, "accelerated");
    bulk(n, Face::Periodic, 0.0, 0.1, "les");
    bulk(n, Face::WALL, 0.0, 0.0, "walls");
    bulk(n, Face::Symmetry, 0.0, 0.0, "mirrors");
    bore(n);
    links(96, 0.0);
    links(96, 0.01);
}
