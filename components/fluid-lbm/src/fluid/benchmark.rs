//! The lattice by itself: whole boxes, a bore that leaves part of a box, spheres that move.

use crate::domain::parameters::{Collision, Parameters, Precision, Walls};
use crate::fluid::lbm_fluid::LbmFluid;
use std::time::Instant;
use tremie_messages::scene::{
    Domain, Face, FluidMaterial, Geometry, Motion, Part, PartBoundary, Pose, Scene,
};
use tremie_messages::{BodyEvent, BodyState, Load};
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Measurement, Quantity};

/// Populations of a cell, each read and written once.
const POPULATIONS: f64 = 19.0;
/// Smagorinsky's constant where there is one.
const SMAGORINSKY: f64 = 0.1;

/// Spheres that move in a box.
#[derive(Clone, Copy)]
struct Spheres {
    /// Cells along an edge of the box.
    room: usize,
    /// Number of spheres along it.
    along: usize,
    /// Their diameters in cells.
    diameter: f64,
    /// Motion of a sphere in a step [cells].
    motion: f64,
}

/// Large ones, small ones, and small ones as slow as the grains in a valve, in a box that stays in
/// the third-level cache as a valve's.
const SPHERES: [Spheres; 3] = [
    Spheres { room: 96, along: 4, diameter: 10.0, motion: 0.01 },
    Spheres { room: 96, along: 16, diameter: 2.5, motion: 0.01 },
    Spheres { room: 48, along: 12, diameter: 2.7, motion: 5e-4 },
];

/// The lattices.
pub fn benchmarks(sizes: &BenchmarkSizes) -> Vec<Benchmark> {
    let mut cases = Vec::new();
    for (precision, name, bytes) in [(Precision::F64, "f64", 8.0), (Precision::F32, "f32", 4.0)] {
        let traffic = 2.0 * POPULATIONS * bytes;
        for &threads in &sizes.threads {
            for (collision, smagorinsky) in
                [("BGK", 0.0), ("TRT", 0.0), ("BGK with Smagorinsky", SMAGORINSKY)]
            {
                let parameters = Parameters {
                    collision: if collision == "TRT" { Collision::Trt } else { Collision::Bgk },
                    precision,
                    smagorinsky,
                    ..Parameters::with_cell(1.0)
                };
                let name = format!("lattice {name}, {collision}, periodic {}³", sizes.edge);
                cases.push(whole(name, parameters, sizes.edge, threads, traffic));
            }
            cases.push(bore(name, precision, sizes.edge, threads, traffic));
            for spheres in SPHERES {
                cases.push(links(name, precision, threads, spheres));
            }
        }
    }
    cases
}

/// A box of cubed cells of 1 m with a fluid of tau = 0.8.
fn scene(edge: usize, face: Face) -> Scene {
    let faces = [0; 3].map(|_| [face.clone(), face.clone()]);
    let fluid = FluidMaterial { velocity: [0.01, 0.0, 0.0], ..FluidMaterial::at_rest(1.0, 0.1) };
    let domain = Domain::new([0.0; 3], [edge as f64; 3], faces);
    Scene { fluid: Some(fluid), ..Scene::empty(domain) }
}

fn fluid(scene: &Scene, parameters: &Parameters, threads: usize) -> Result<LbmFluid, String> {
    let said = |problems: Vec<tremie_messages::Problem>| {
        problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    let time_step = parameters.resolve(scene).map_err(said)?.time_step;
    LbmFluid::new(scene, parameters, time_step, threads).map_err(said)
}

/// Seconds of a step: the mean over as many pairs as take about `seconds`.
fn seconds_per_step(
    fluid: &mut LbmFluid,
    bodies: &mut [BodyState],
    loads: &mut [Load],
    motion: f64,
    seconds: f64,
) -> Result<f64, String> {
    let (start, mut steps) = (Instant::now(), 0);
    while steps == 0 || start.elapsed().as_secs_f64() < seconds {
        for _ in 0..2 {
            for body in &mut *bodies {
                body.position[0] += motion;
            }
            fluid.step(bodies, loads).map_err(|error| error.to_string())?;
        }
        steps += 2;
    }
    Ok(start.elapsed().as_secs_f64() / f64::from(steps))
}

fn started(mut fluid: LbmFluid) -> Result<LbmFluid, String> {
    fluid.start(&[], &mut []).map_err(|error| error.to_string())?;
    Ok(fluid)
}

/// A whole box without bodies or walls.
fn whole(
    name: String,
    parameters: Parameters,
    edge: usize,
    threads: usize,
    traffic: f64,
) -> Benchmark {
    let make = move || {
        let mut fluid = started(fluid(&scene(edge, Face::Periodic), &parameters, threads)?)?;
        let cells = fluid.diagnostics().fluid_cells as f64;
        let measure: Measurement = Box::new(move |seconds| {
            let step = seconds_per_step(&mut fluid, &mut [], &mut [], 0.0, seconds)?;
            Ok(vec![1e-6 * cells / step])
        });
        Ok(measure)
    };
    let quantities = vec![Quantity { traffic: Some(traffic), ..Quantity::new("", "MLUPS") }];
    Benchmark { name, threads, quantities, make: Box::new(make) }
}

/// A bore and the bolt in it, and the box around it, full: their times and memory. 44 % of the box
/// are fluid.
fn bore(
    precise: &str,
    precision: Precision,
    edge: usize,
    threads: usize,
    traffic: f64,
) -> Benchmark {
    let make = move || {
        let parameters = Parameters {
            collision: Collision::Bgk,
            precision,
            walls: Walls::Halfway,
            ..Parameters::with_cell(1.0)
        };
        let mut dense = started(fluid(&scene(edge, Face::Periodic), &parameters, threads)?)?;
        let mut bored = scene(edge, Face::WALL);
        let size = edge as f64;
        bored.parts = [("bore", 0.4375, true), ("bolt", 0.219, false)]
            .map(|(name, radius, cavity)| Part {
                name: name.into(),
                geometry: Geometry::Cylinder { radius: radius * size, length: 3.0 * size },
                pose: Pose { position: [0.501 * size; 3], ..Pose::IDENTITY },
                cavity,
                material: "wall".into(),
                motion: Motion::Fixed,
                boundary: PartBoundary::Wall,
            })
            .to_vec();
        let mut bored = started(fluid(&bored, &parameters, threads)?)?;
        let measure: Measurement = Box::new(move |seconds| {
            let whole = seconds_per_step(&mut dense, &mut [], &mut [], 0.0, 0.5 * seconds)?;
            let part = seconds_per_step(&mut bored, &mut [], &mut [], 0.0, 0.5 * seconds)?;
            let cells = bored.diagnostics().fluid_cells as f64;
            let bytes = [&bored, &dense].map(|fluid| fluid.memory_bytes() as f64);
            Ok(vec![1e-6 * cells / part, part / whole, bytes[0] / bytes[1], bytes[0] / cells])
        });
        Ok(measure)
    };
    let quantities = vec![
        Quantity { traffic: Some(traffic), ..Quantity::new("", "MLUPS") },
        Quantity::new("time over the whole box's", "1"),
        Quantity::new("memory over the whole box's", "1"),
        Quantity::new("memory of a fluid cell", "B"),
    ];
    let name = format!("lattice {precise}, BGK, bore with a bolt in {edge}³");
    Benchmark { name, threads, quantities, make: Box::new(make) }
}

/// Cost of the links of moving spheres beside the lattice without them.
fn links(
    precise: &str,
    precision: Precision,
    threads: usize,
    Spheres { room, along, diameter, motion }: Spheres,
) -> Benchmark {
    let pitch = (room / along) as f64;
    let make = move || {
        let parameters = Parameters { precision, ..Parameters::with_cell(1.0) };
        let scene = scene(room, Face::Periodic);
        let mut empty = started(fluid(&scene, &parameters, threads)?)?;
        let mut filled = fluid(&scene, &parameters, threads)?;
        let place = |k: usize| {
            let at = [k % along, k / along % along, k / along / along];
            at.map(|k| (k as f64 + 0.5) * pitch + 0.123)
        };
        let state = |k: usize| BodyState {
            velocity: [motion, 0.0, 0.0],
            ..BodyState::at_rest(k as u64, place(k))
        };
        let mut bodies: Vec<BodyState> = (0..along.pow(3)).map(state).collect();
        let event = |body: &BodyState| BodyEvent {
            id: body.id,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::SPHERE,
            motion: BodyEvent::FREE,
            set: 0,
            mass: 1.0,
            size: [0.5 * diameter, 0.0, 0.0],
            table: 0,
        };
        let events: Vec<BodyEvent> = bodies.iter().map(event).collect();
        let mut loads = vec![Load::default(); bodies.len()];
        filled.apply_events(&events).map_err(|error| error.to_string())?;
        filled.start(&bodies, &mut loads).map_err(|error| error.to_string())?;
        let measure: Measurement = Box::new(move |seconds| {
            let without = seconds_per_step(&mut empty, &mut [], &mut [], 0.0, 0.5 * seconds)?;
            let with =
                seconds_per_step(&mut filled, &mut bodies, &mut loads, motion, 0.5 * seconds)?;
            let links = filled.diagnostics().links as f64;
            Ok(vec![1e9 * threads as f64 * (with - without) / links])
        });
        Ok(measure)
    };
    let spheres = along.pow(3);
    let name = format!(
        "lattice {precise}, links of {spheres} spheres of {diameter} cells in {room}³, moving {motion} a step"
    );
    let quantities = vec![Quantity::new("", "core ns a link")];
    Benchmark { name, threads, quantities, make: Box::new(make) }
}
