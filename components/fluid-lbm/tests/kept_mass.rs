//! Closed boxes keep their mass.

mod common;

use common::*;
use tremie_fluid_lbm::{Collision, Precision, Walls};
use tremie_messages::scene::Face;

/// A wall that slides pushes fluid into one edge and takes it out of the other, where the density is another. On each face
/// in turn, and on two that meet: in f64 the mass stays to 1e-13 in 800 steps, in f32 to 1e-7 (rounding of the
/// collision).
#[test]
fn a_box_with_lids_keeps_its_mass() {
    let velocity = |axis: usize| {
        let mut velocity = [0.05, -0.02, 0.04];
        velocity[axis] = 0.0;
        velocity
    };
    let one = (0..6).map(|k| vec![(k / 2, k % 2)]);
    let lids = one.chain([vec![(0, 1), (2, 1)], vec![(1, 0), (2, 1)]]);
    for lids in lids {
        for k in 0..8 {
            let mut case = Case::new([13, 11, 16], [WALL; 3], 0.55);
            case.collision = [Collision::Trt, Collision::Bgk][k % 2];
            case.walls = [Walls::Bouzidi, Walls::Halfway][k / 2 % 2];
            let bound;
            (case.precision, bound) = [(Precision::F64, 1e-13), (Precision::F32, 1e-7)][k / 4];
            let mut scene = case.scene();
            for &(axis, side) in &lids {
                scene.domain.faces[axis][side] = Face::Wall { velocity: velocity(axis) };
            }
            let mut fluid = case.fluid_of(&scene);
            let mass = fluid.ledger().mass;
            for step in 0..800 {
                fluid.step(&[], &mut []).unwrap();
                if case.precision == Precision::F64 && step % 100 == 3 {
                    closes(&fluid, 1e-11);
                }
            }
            let gained = fluid.ledger().mass / mass - 1.0;
            let scheme = format!("{lids:?} {:?} {:?}", case.collision, case.walls);
            println!("{scheme} {:?}: {gained:e}", case.precision);
            assert!(gained.abs() < bound, "{scheme} {:?}: {gained}", case.precision);
            assert!(fluid.diagnostics().max_speed > 0.02, "{scheme}");
        }
    }
}
