//! A reservoir against what it stands for: a piston that moves through the fluid, and drives it
//! through an orifice (after Mutabaruka & Kamrin, Figs. 9 and 10, smaller).

use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid, Refill};
use tremie_messages::BodyState;
use tremie_messages::scene::{Course, Face, Geometry, Motion, Outflow, Reservoir, Scene};

/// Cells across the tube, from the interface to the orifice's plate, of the plate, and behind it.
const WIDTH: usize = 8;
const BEFORE: usize = 20;
const PLATE: usize = 3;
const BEHIND: usize = 15;
/// Cells between piston and interface.
const CYLINDER: usize = 24;
/// Cells that the piston takes at the start.
const PISTON: usize = 4;
/// The piston's velocity, and the steps in which it comes to it.
const SPEED: f64 = 2e-3;
const RAMP: f64 = 1000.0;
const STEPS: usize = 3000;

/// Half a cosine.
fn factor(time: f64) -> f64 {
    0.5 * (1.0 - (core::f64::consts::PI * (time / RAMP).min(1.0)).cos())
}

/// A square tube with an orifice of half its width, the interface at `interface`, and its sides.
fn tube(interface: usize, sides: Face) -> (Case, Scene) {
    let length = interface + BEFORE + PLATE + BEHIND;
    let mut case = Case::new([length, WIDTH, WIDTH], [WALL, sides.clone(), sides], 0.52);
    case.collision = Collision::Bgk;
    case.refill = Refill::Mass;
    let mut scene = case.scene();
    scene.domain.faces[0][1] =
        Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
    let (width, quarter) = (WIDTH as f64, WIDTH as f64 / 4.0);
    let x = (interface + BEFORE) as f64 + 0.5 * PLATE as f64;
    for (k, at) in [0.5 * quarter - 1.0, width - 0.5 * quarter + 1.0].into_iter().enumerate() {
        let size = [PLATE as f64, quarter + 2.0, width + 2.0];
        let middle = 0.5 * width;
        scene.parts.push(part(&format!("y{k}"), Geometry::Box { size }, [x, at, middle]));
        let size = [PLATE as f64, width + 2.0, quarter + 2.0];
        scene.parts.push(part(&format!("z{k}"), Geometry::Box { size }, [x, middle, at]));
    }
    (case, scene)
}

/// Mean velocity along the tube and mean pressure, 5 to 10 cells behind the interface.
fn seen(fluid: &LbmFluid, interface: usize) -> [f64; 2] {
    let (mut sum, mut count) = ([0.0; 2], 0.0);
    for cell in cells(fluid).filter(|c| (interface + 5..interface + 10).contains(&c[0])) {
        sum[0] += fluid.velocity_at(cell)[0];
        sum[1] += fluid.pressure_at(cell);
        count += 1.0;
    }
    sum.map(|s| s / count)
}

fn behind_a_reservoir(sides: Face) -> Vec<[f64; 2]> {
    let (case, mut scene) = tube(0, sides);
    let area = (WIDTH * WIDTH) as f64;
    let mut reservoir = Reservoir::new(area, area * CYLINDER as f64, SPEED);
    let point = |k: u32| [f64::from(k) * RAMP / 100.0, factor(f64::from(k) * RAMP / 100.0)];
    reservoir.course = Course::Points((0..=100).map(point).collect());
    scene.domain.faces[0][0] = Face::Reservoir(reservoir);
    let mut fluid = case.fluid_of(&scene);
    let step = |_| {
        fluid.step(&[], &mut []).unwrap();
        seen(&fluid, 0)
    };
    (0..STEPS).map(step).collect()
}

fn behind_a_piston(sides: Face) -> Vec<[f64; 2]> {
    let interface = PISTON + CYLINDER;
    let (case, mut scene) = tube(interface, sides);
    let beyond = WIDTH as f64 + 4.0;
    let size = [40.0, beyond, beyond];
    let middle = 0.5 * WIDTH as f64;
    let mut piston = part("piston", Geometry::Box { size }, [PISTON as f64 - 20.0, middle, middle]);
    piston.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(piston);
    let index = scene.parts.len() as u64 - 1;
    let mut fluid = case.fluid_of(&scene);
    let mut bodies = [BodyState::at_rest(1, [PISTON as f64 - 20.0, middle, middle])];
    fluid.apply_events(&[added_part(1, index)]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let step = |k: usize| {
        bodies[0].velocity[0] = SPEED * factor(k as f64 + 0.5);
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        seen(&fluid, interface)
    };
    (0..STEPS).map(step).collect()
}

/// Between mirrors: mean velocity within 0.2 % of the piston's in both, mean pressure of both
/// within 0.5 %.
#[test]
fn a_reservoir_stands_for_a_piston() {
    a_reservoir_does_as_a_piston(&SYMMETRY, [2e-3, 5e-3]);
}

/// Between walls, which take links from the piston along its rim: within 0.3 % and 1 %.
#[test]
fn a_reservoir_stands_for_a_piston_between_walls() {
    a_reservoir_does_as_a_piston(&WALL, [3e-3, 1e-2]);
}

/// Compares mean velocities with the piston's and mean pressures with each other, once the ramp is
/// over; while it lasts the pressures rise together (their correlation is above 0.999).
fn a_reservoir_does_as_a_piston(sides: &Face, [most, most_of_pressure]: [f64; 2]) {
    let [virtually, really] = [behind_a_reservoir(sides.clone()), behind_a_piston(sides.clone())];
    let mean = |run: &[[f64; 2]], k: usize| {
        let tail = &run[RAMP as usize..];
        tail.iter().map(|v| v[k]).sum::<f64>() / tail.len() as f64
    };
    let speeds = [mean(&virtually, 0), mean(&really, 0)].map(|u| u / SPEED);
    let pressures = [mean(&virtually, 1), mean(&really, 1)];
    let (mut cross, mut squares) = (0.0, [0.0; 2]);
    for (one, other) in virtually[..RAMP as usize].iter().zip(&really) {
        cross += one[1] * other[1];
        squares[0] += one[1] * one[1];
        squares[1] += other[1] * other[1];
    }
    let correlation = cross / (squares[0] * squares[1]).sqrt();
    println!("speeds {speeds:?}, pressures {pressures:?}, correlation {correlation}");
    assert!(speeds.iter().all(|u| (u - 1.0).abs() < most), "{speeds:?}");
    assert!((pressures[0] / pressures[1] - 1.0).abs() < most_of_pressure, "{pressures:?}");
    assert!(correlation > 0.999, "{correlation}");
}
