//! Moving parts whose cells and links are found only now and then: `part_step`.

use crate::common::*;
use std::f64::consts::PI;
use tremie_fluid_lbm::{LbmFluid, Refill};
use tremie_messages::scene::{Geometry, Motion, Scene};
use tremie_messages::{BodyState, Load};

/// A disc with a hub, on an axis along z, in a box of 24 x 24 x 30 cells.
fn scene(case: &Case) -> Scene {
    let mut scene = case.scene();
    let profile = vec![[0.0, -3.0], [3.3, -3.0], [4.1, -1.2], [7.2, -1.2], [7.2, 2.1], [0.0, 2.1]];
    let mut disc = part("disc", Geometry::Revolved { profile }, [12.0, 12.0, 11.3]);
    disc.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(disc);
    scene
}

fn case() -> Case {
    let mut case = Case::new([24, 24, 30], [WALL, WALL, PERIODIC], 0.7);
    case.refill = Refill::Mass;
    case.average_force = true;
    case
}

fn fluid(case: &Case, part_step: f64) -> LbmFluid {
    let parameters = tremie_fluid_lbm::Parameters { part_step, ..case.parameters() };
    LbmFluid::with_variant(&scene(case), &parameters, 1.0, case.threads, case.variant).unwrap()
}

/// The disc rises by 3 cells in 300 steps, after half a cosine, and turns a little about x if it
/// should. `each` is called after each step.
fn run(fluid: &mut LbmFluid, turns: bool, mut each: impl FnMut(&mut LbmFluid, usize, &Load)) {
    let mut body = [BodyState::at_rest(1, [12.0, 12.0, 11.3])];
    fluid.apply_events(&[added_part(1, 0)]).unwrap();
    let mut loads = loads_of(&body);
    fluid.start(&body, &mut loads).unwrap();
    for k in 0..300 {
        let phase = PI * (k as f64 + 1.0) / 300.0;
        body[0].position[2] = 11.3 + 1.5 * (1.0 - phase.cos());
        body[0].velocity[2] = 1.5 * phase.sin() * PI / 300.0;
        if turns {
            let half = 0.01 * phase.sin();
            body[0].orientation = [half.sin(), 0.0, 0.0, half.cos()];
            body[0].angular_velocity[0] = 0.02 * phase.cos() * PI / 300.0;
        }
        fluid.step(&body, &mut loads).unwrap();
        closes(fluid, 1e-11);
        each(fluid, k, &loads[0]);
    }
}

/// Force and torque of each step, averaged over 10 steps, and the velocity beside the disc at the
/// end.
fn course(part_step: f64, turns: bool) -> (Vec<[f64; 2]>, [f64; 3]) {
    let mut fluid = fluid(&case(), part_step);
    let mut means = vec![[0.0; 2]; 30];
    run(&mut fluid, turns, |_, k, load| {
        means[k / 10][0] += load.force[2] / 10.0;
        means[k / 10][1] += load.torque[0] / 10.0;
    });
    (means, fluid.velocity_at([21, 12, 14]))
}

/// With the default step the force on the disc, over 10 steps each, is that of finding links in
/// each step to 1.5 % of the largest, the torque while it turns to 3 %, the velocity beside it to 1
/// %. Means over the run: 0.2 %.
#[test]
fn the_flow_is_that_of_finding_links_in_each_step() {
    for turns in [false, true] {
        let (exact, u) = course(0.0, turns);
        let (stepped, v) = course(1.0 / 32.0, turns);
        for (k, tolerance) in [(0, 0.015), (1, 0.03)] {
            let largest = exact.iter().map(|m| m[k].abs()).fold(0.0, f64::max);
            let off = exact.iter().zip(&stepped).map(|(a, b)| (a[k] - b[k]).abs());
            let off = off.fold(0.0, f64::max) / largest;
            let mean = |run: &[[f64; 2]]| run.iter().map(|m| m[k]).sum::<f64>() / 30.0;
            let drift = (mean(&exact) - mean(&stepped)).abs() / largest;
            println!("{turns} {k}: off by {off:.2e} of {largest:.2e}, means by {drift:.2e}");
            if k == 0 || turns {
                assert!(off < tolerance && drift < 2e-3, "{turns} {k}: {off} {drift}");
            }
        }
        let gap = norm([u[0] - v[0], u[1] - v[1], u[2] - v[2]]) / norm(u);
        println!("velocity: {gap:.2e}");
        assert!(gap < 0.01, "{u:?} {v:?}");
    }
}

/// The links found depend on the pose alone: finding all of them anew changes no bit, and threads
/// neither.
#[test]
fn the_way_to_a_pose_leaves_no_trace() {
    let bits = |threads: usize, again: bool| {
        let mut case = case();
        case.threads = threads;
        let mut fluid = fluid(&case, 1.0 / 8.0);
        let mut bits = Vec::new();
        run(&mut fluid, true, |fluid, k, load| {
            bits.extend(load.force.iter().chain(&load.torque).map(|x| x.to_bits()));
            if again && k % 7 == 0 {
                // Lists of bodies that change make all links be found anew.
                fluid.apply_events(&[added(9, 1.0), removed(9)]).unwrap();
            }
        });
        bits
    };
    let reference = bits(1, false);
    assert!(bits(2, false) == reference && bits(3, true) == reference);
}

/// A block at rest between rounded poses is where it is: drag and lift of a flow along it are those
/// of links found at its pose, to 1e-9; at the rounded pose, 0.1 cells lower, they differ by more
/// than 1e-4.
#[test]
fn walls_are_where_they_are_between_rounded_poses() {
    let drag = |part_step: f64, lift: f64| {
        let mut case = Case::new([24, 16, 16], [PERIODIC, SYMMETRY, WALL], 0.8);
        case.acceleration[0] = 1e-5;
        let mut scene = case.scene();
        let size = [6.8, 20.0, 6.8];
        let mut block = part("block", Geometry::Box { size }, [12.0, 8.0, 5.9]);
        block.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(block);
        let parameters = tremie_fluid_lbm::Parameters { part_step, ..case.parameters() };
        let mut fluid = LbmFluid::with_variant(&scene, &parameters, 1.0, 2, case.variant).unwrap();
        let body = [BodyState::at_rest(1, [12.0, 8.0, 5.9 + lift])];
        fluid.apply_events(&[added_part(1, 0)]).unwrap();
        let mut loads = loads_of(&body);
        fluid.start(&body, &mut loads).unwrap();
        for _ in 0..800 {
            fluid.step(&body, &mut loads).unwrap();
        }
        loads[0].force
    };
    let (exact, followed, below) = (drag(0.0, 0.1), drag(0.25, 0.1), drag(0.0, 0.0));
    println!("{exact:?} {followed:?} {below:?}");
    for a in [0, 2] {
        assert!((followed[a] - exact[a]).abs() < 1e-9 * exact[a].abs(), "{followed:?} {exact:?}");
        assert!((below[a] - exact[a]).abs() > 1e-4 * exact[a].abs(), "{below:?} {exact:?}");
    }
}
