//! Cells that nothing flows through do not ring on: when grains have come to rest, all fluid does.

use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid};
use tremie_messages::BodyState;
use tremie_messages::scene::{Course, Face, Geometry, Outflow, Scene};

/// Odd numbers of cells: between walls an even number apart a box itself has a wave of two steps
/// that nothing damps.
const BOX: [usize; 3] = [29, 27, 31];
const RADIUS: f64 = 4.0;

/// Largest and median speed of the fluid.
fn speeds(fluid: &LbmFluid) -> [f64; 2] {
    let fluid_cells = cells(fluid).filter(|&at| !fluid.node(at).solid);
    let speed = |at| fluid.velocity_at(at).iter().map(|u| u * u).sum::<f64>().sqrt();
    let mut all: Vec<f64> = fluid_cells.map(speed).collect();
    all.sort_by(f64::total_cmp);
    [all[all.len() - 1], all[all.len() / 2]]
}

/// Grains of 8 cells across come down to their places through a fluid that moves; then the fluid
/// comes to rest. Where any cell rings, it keeps the speed of 1e-3 that all had at the start.
fn comes_to_rest(name: &str, case: &Case, scene: &Scene, grains: &[[f64; 3]]) {
    let mut fluid = case.fluid_of(scene);
    let drop = 1.5;
    let above = |at: [f64; 3]| [at[0], at[1], at[2] + drop];
    let mut bodies: Vec<_> =
        (1..).zip(grains).map(|(id, &at)| BodyState::at_rest(id, above(at))).collect();
    let events: Vec<_> = bodies.iter().map(|body| added(body.id, RADIUS)).collect();
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    for step in 0..2500 {
        let speed = if step < 300 { drop / 300.0 } else { 0.0 };
        bodies.iter_mut().for_each(|body| body.velocity = [0.0, 0.0, -speed]);
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        if step % 101 == 0 {
            closes(&fluid, 1e-10);
        }
    }
    let [most, median] = speeds(&fluid);
    println!("{name}: {most:.1e}, median {median:.1e}");
    assert!(most < 3.0 * median && most < 1e-4, "{name}: {most} {median}");
}

fn moving_fluid() -> Case {
    let mut case = Case::new(BOX, [WALL; 3], 0.8);
    case.velocity = [1e-3, 5e-4, -1e-3];
    case
}

/// On the floor in five places, along an edge and in a corner.
#[test]
fn a_grain_at_walls() {
    let r = RADIUS;
    let case = moving_fluid();
    for (name, at) in [
        ("floor", [14.2, 13.6, r - 0.02]),
        ("floor, over a cell", [14.5, 13.5, r - 0.02]),
        ("floor, over a corner of cells", [14.0, 13.0, r - 0.02]),
        ("floor, a hair above", [14.3, 13.8, r + 0.05]),
        ("floor, deep", [14.1, 13.9, r - 0.2]),
        ("edge", [14.2, r - 0.01, r - 0.02]),
        ("edge, over a side of cells", [14.0, r - 0.01, r - 0.02]),
        ("edge, beside", [14.4, r + 0.1, r + 0.02]),
        ("corner", [r - 0.01, r - 0.02, r - 0.02]),
        ("corner, beside", [r + 0.2, r + 0.1, r - 0.02]),
    ] {
        comes_to_rest(name, &case, &case.scene(), &[at]);
    }
}

/// Grains that touch: two, a pyramid of four, and one on a heap in the corner.
#[test]
fn grains_that_touch() {
    let (r, d) = (RADIUS, 2.0 * RADIUS);
    let case = moving_fluid();
    let [x, y] = [9.3, 9.1];
    let pyramid = [
        [x, y, r],
        [x + d, y, r],
        [x + r, y + 0.75f64.sqrt() * d, r],
        [x + r, y + r / 3f64.sqrt(), r + (2.0f64 / 3.0).sqrt() * d],
    ];
    let corner = [[r, r, r], [3.0 * r, r, r], [r, 3.0 * r, r], [r, r, 3.0 * r]];
    comes_to_rest("pair", &case, &case.scene(), &[[x, y, r], [x + d - 0.02, y, r]]);
    comes_to_rest("pyramid", &case, &case.scene(), &pyramid);
    comes_to_rest("corner", &case, &case.scene(), &corner);
}

/// On a block that stands aslant, interpolated or not; and in nooks between blocks without any
/// grain.
#[test]
fn nooks_of_parts() {
    for walls in [tremie_fluid_lbm::Walls::Bouzidi, tremie_fluid_lbm::Walls::Halfway] {
        let mut case = moving_fluid();
        case.walls = walls;
        let mut scene = case.scene();
        let mut block = part("block", Geometry::Box { size: [9.3, 8.1, 9.2] }, [9.3, 8.1, 6.2]);
        block.pose.orientation = [0.1, 0.3, 0.2, (1.0_f64 - 0.14).sqrt()];
        scene.parts.push(block);
        scene.parts.push(part("ball", Geometry::Sphere { radius: 5.2 }, [18.4, 14.2, 5.1]));
        comes_to_rest("nooks", &case, &scene, &[]);
        comes_to_rest("on them", &case, &scene, &[[10.2, 17.8, RADIUS]]);
    }
}

/// Blocks that leave a slit of one layer in the far wall of a box of 13 x 5 x 5 cells, to its end.
const SLIT: [([f64; 3], [f64; 3]); 2] =
    [([8.0, 0.0, 0.0], [13.0, 5.0, 2.0]), ([8.0, 0.0, 3.0], [13.0, 5.0, 5.0])];

/// Blocks that leave one cell of the slit.
const NOOK: [([f64; 3], [f64; 3]); 3] = [
    ([8.0, 0.0, 2.0], [13.0, 2.0, 3.0]),
    ([8.0, 3.0, 2.0], [13.0, 5.0, 3.0]),
    ([9.0, 2.0, 2.0], [13.0, 3.0, 3.0]),
];

/// Where viscosity is next to none, the pressure in these cells follows that of the box all the same.
fn pressure_reaches(name: &str, blocks: &[([f64; 3], [f64; 3])], cells: &[[usize; 3]]) {
    const PRESSURE: f64 = 1e-3;
    for collision in [Collision::Bgk, Collision::Trt] {
        let mut case = Case::new([13, 5, 5], [WALL; 3], 0.500_01);
        (case.collision, case.bulk, case.smagorinsky) = (collision, Some(1.0), 0.1);
        let mut scene = case.scene();
        scene.domain.faces[0][0] = Face::Pressure {
            pressure: PRESSURE,
            course: Course::Points(vec![[0.0, 0.0], [100.0, 1.0]]),
            outflow: Outflow::Absorbing,
        };
        for (n, (min, max)) in blocks.iter().enumerate() {
            let size = std::array::from_fn(|a| max[a] - min[a]);
            let middle = std::array::from_fn(|a| 0.5 * (min[a] + max[a]));
            scene.parts.push(part(&format!("block {n}"), Geometry::Box { size }, middle));
        }
        let mut fluid = case.fluid_of(&scene);
        fluid.start(&[], &mut []).unwrap();
        for _ in 0..3000 {
            fluid.step(&[], &mut []).unwrap();
        }
        let beside = fluid.pressure_at([7, 2, 2]);
        assert!((beside / PRESSURE - 1.0).abs() < 0.1, "{collision:?}: {beside}");
        for &cell in cells {
            let found = fluid.pressure_at(cell);
            println!("{collision:?}, {name} {cell:?}: {found:.3e}, beside {beside:.3e}");
            assert!((found / beside - 1.0).abs() < 0.05, "{collision:?} {name} {cell:?}: {found}");
        }
    }
}

#[test]
fn the_pressure_in_a_nook_is_that_beside_it() {
    pressure_reaches("nook", &[SLIT.as_slice(), NOOK.as_slice()].concat(), &[[8, 2, 2]]);
}

#[test]
fn the_pressure_in_a_slit_of_one_layer_is_that_beside_it() {
    pressure_reaches("slit", &SLIT, &[[8, 2, 2], [10, 2, 2], [12, 2, 2], [12, 0, 2]]);
}
