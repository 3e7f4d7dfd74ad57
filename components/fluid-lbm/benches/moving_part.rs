//! Cost of a step with a part that moves: half a disc valve in a chamber, 2e5 cells.
//!
//! `cargo bench -p tremie-fluid-lbm --no-default-features --bench moving_part [-- CELLS_PER_MM]`

use std::time::Instant;
use tremie_fluid_lbm::{Collision, LbmFluid, Parameters, Precision};
use tremie_messages::scene::{
    Domain, Face, FluidMaterial, Geometry, Motion, Part, PartBoundary, Pose, Scene,
};
use tremie_messages::units::Time;
use tremie_messages::{BodyEvent, BodyState, Load};
use tremie_test_support::processor_seconds;

/// Numbers of the profiles [mm]: `[r, z]`.
const CHAMBER: [[f64; 2]; 6] =
    [[0.0, -6.0], [4.75, -6.0], [4.75, -0.991], [6.5, 0.0], [15.0, 0.0], [15.0, 16.0]];
const VALVE: [[f64; 2]; 7] = [
    [0.0, -0.991],
    [4.75, -0.991],
    [6.5, 0.0],
    [6.5, -0.48],
    [11.0, -0.48],
    [11.0, 4.163],
    [0.0, 4.163],
];

fn part(name: &str, profile: Vec<[f64; 2]>, cavity: bool, position: [f64; 3]) -> Part {
    Part {
        name: name.into(),
        geometry: Geometry::Revolved { profile },
        pose: Pose { position, ..Pose::IDENTITY },
        cavity,
        material: "steel".into(),
        motion: if cavity { Motion::Fixed } else { Motion::Prescribed(Vec::new()) },
        boundary: PartBoundary::Wall,
    }
}

/// Half of a valve in a chamber, enlarged, and where the valve is.
fn valve_in_a_chamber(scale: f64) -> (Scene, [f64; 3]) {
    let scaled = |profile: &[[f64; 2]]| -> Vec<[f64; 2]> {
        profile.iter().map(|p| p.map(|x| x * scale)).collect()
    };
    let edges = [15.0, 30.0, 21.0].map(|edge: f64| (edge * scale + 0.5).ceil());
    let origin = [0.0, 0.5 * edges[1], edges[2] - (15.0 * scale).floor() - 0.25];
    let mut faces = Face::WALLS;
    faces[0][0] = Face::Symmetry;
    let mut chamber = scaled(&CHAMBER);
    chamber.push([0.0, 16.0 * scale]);
    let lift = 1.5 * scale;
    let position = [origin[0], origin[1], origin[2] + lift];
    let scene = Scene {
        fluid: Some(FluidMaterial {
            inside: vec![[0.5, origin[1], 3.0]],
            ..FluidMaterial::at_rest(1.0, 1e-3)
        }),
        parts: vec![
            part("chamber", chamber, true, origin),
            part("valve", scaled(&VALVE), false, position),
        ],
        ..Scene::empty(Domain::new([0.0; 3], edges, faces))
    };
    (scene, position)
}

/// Seconds of a step, the mean over some: of the processor for one thread, else of the clock.
fn measure(scale: f64, speed: Option<f64>, threads: usize) {
    let (scene, position) = valve_in_a_chamber(scale);
    let parameters = Parameters {
        time_step: Some(Time(1.0)),
        collision: Collision::Bgk,
        smagorinsky: 0.17,
        precision: Precision::F32,
        ..Parameters::with_cell(1.0)
    };
    let mut fluid = LbmFluid::new(&scene, &parameters, 1.0, threads).unwrap();
    let mut bodies = Vec::new();
    if let Some(speed) = speed {
        let event = BodyEvent {
            id: 1,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::PART,
            motion: BodyEvent::PRESCRIBED,
            set: 0,
            mass: 1.0,
            size: [0.0; 3],
            table: 1,
        };
        fluid.apply_events(&[event]).unwrap();
        bodies.push(BodyState::at_rest(1, position));
        bodies[0].velocity[2] = speed;
    }
    let mut loads = vec![Load::default(); bodies.len()];
    fluid.start(&bodies, &mut loads).unwrap();
    let mut step = |count: usize| {
        for _ in 0..count {
            for body in &mut bodies {
                body.position[2] += body.velocity[2];
            }
            fluid.step(&bodies, &mut loads).unwrap();
        }
    };
    step(4);
    let (mut total, mut steps) = (0.0, 0_u32);
    while total < 1.0 {
        let (start, busy) = (Instant::now(), processor_seconds());
        step(20);
        total +=
            if threads == 1 { processor_seconds() - busy } else { start.elapsed().as_secs_f64() };
        steps += 20;
    }
    let links = fluid.diagnostics().links;
    println!(
        "{:>7} cells, {links:>6} links, {threads} threads, {:>12}: {:7.3} ms a step",
        fluid.diagnostics().fluid_cells,
        speed.map_or("no part".into(), |speed| format!("{speed:.0e} cells")),
        1e3 * total / f64::from(steps)
    );
}

fn main() {
    let scale = std::env::args().skip(1).find_map(|a| a.parse().ok()).unwrap_or(1.0 / 0.3);
    for threads in [1, 2] {
        for speed in [None, Some(0.0), Some(1e-4), Some(1e-3), Some(1e-2)] {
            measure(scale, speed, threads);
        }
    }
}
