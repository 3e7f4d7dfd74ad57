//! Symmetry planes: half a flow is the flow.

use crate::common::*;
use tremie_messages::scene::{Face, Geometry, Scene};
use tremie_messages::{BodyState, Load};

/// A channel between walls along `axis`, whole, or its lower half with a mirror in the middle.
fn channel(axis: usize, cells: [usize; 3], half: bool) -> (Case, Scene) {
    let mut faces = [PERIODIC; 3];
    faces[axis] = WALL;
    let mut case = Case::new(cells, faces, 0.8);
    let along = (axis + 1) % 3;
    case.acceleration[along] = 1e-5;
    let mut scene = case.scene();
    if half {
        scene.domain.faces[axis][1] = Face::Symmetry;
        scene.domain.max[axis] = 0.5 * cells[axis] as f64;
    }
    (case, scene)
}

/// A flow that is symmetric to rounding stays equal in both to 1e-15 over 300 steps: with a sphere
/// off the middle and its mirror image on the other side, at speeds of 0.02.
#[test]
fn half_a_channel_is_the_channel() {
    for axis in 0..3 {
        let mut cells = [14; 3];
        cells[axis] = 24;
        let bodies = |both: bool| {
            let mut one = BodyState::at_rest(1, [6.3; 3]);
            one.position[axis] = 8.6;
            one.velocity[(axis + 1) % 3] = 0.02;
            one.angular_velocity = [1e-3; 3];
            let mut other = BodyState { id: 2, ..one };
            other.position[axis] = 24.0 - 8.6;
            for a in (0..3).filter(|&a| a != axis) {
                other.angular_velocity[a] = -1e-3;
            }
            if both { vec![one, other] } else { vec![one] }
        };
        let mut fluids = [false, true].map(|half| {
            let (case, scene) = channel(axis, cells, half);
            case.fluid_of(&scene)
        });
        let mut states = [bodies(true), bodies(false)];
        let mut forces = [[0.0; 3]; 2];
        for k in 0..2 {
            let events: Vec<_> = states[k].iter().map(|b| added(b.id, 3.0)).collect();
            fluids[k].apply_events(&events).unwrap();
            let mut loads = loads_of(&states[k]);
            fluids[k].start(&states[k], &mut loads).unwrap();
            for _ in 0..300 {
                advance(&mut states[k]);
                fluids[k].step(&states[k], &mut loads).unwrap();
            }
            forces[k] = loads[0].force;
        }
        let [whole, half] = fluids;
        for cell in cells_of(&half) {
            assert_eq!(whole.node(cell).solid, half.node(cell).solid);
            if !half.node(cell).solid {
                let (a, b) = (whole.populations_at(cell), half.populations_at(cell));
                for i in 0..19 {
                    assert!(
                        (a[i] - b[i]).abs() < 1e-15,
                        "axis {axis} {cell:?} {i} {} {}",
                        a[i],
                        b[i]
                    );
                }
            }
        }
        assert!(norm(forces[0]) > 1e-3);
        for a in 0..3 {
            assert!((forces[0][a] - forces[1][a]).abs() < 1e-13);
        }
    }
}

fn cells_of(fluid: &tremie_fluid_lbm::LbmFluid) -> Vec<[usize; 3]> {
    cells(fluid).collect()
}

/// Load on a sphere on a mirror is that on the whole sphere: 1e-12 of the force, its centre on a
/// face between cells.
#[test]
fn a_sphere_cut_in_half_feels_what_the_whole_one_does() {
    let run = |half: bool| -> (Load, f64) {
        let case = Case::new([28, 20, 20], [PERIODIC, SYMMETRY, PERIODIC], 0.7);
        let mut scene = case.scene();
        let mut body = BodyState::at_rest(1, [14.2, 10.0, 9.7]);
        body.velocity = [0.03, 0.0, -0.01];
        body.angular_velocity = [0.0, 0.004, 0.0];
        if half {
            scene.domain.max[1] = 10.0;
        }
        let mut fluid = case.fluid_of(&scene);
        fluid.apply_events(&[added(1, 4.3)]).unwrap();
        let mut bodies = [body];
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        for _ in 0..200 {
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads).unwrap();
            let ledger = fluid.ledger();
            let terms = ledger.momentum_terms();
            for a in 0..3 {
                assert!(
                    (ledger.momentum_change[a] - terms[a]).abs() < 1e-11,
                    "{half} {a} {ledger:?} {terms:?}"
                );
            }
            let given = ledger.delivered[0];
            assert!((given - (ledger.images[0] - ledger.bodies[0])).abs() < 1e-13);
        }
        (loads[0], fluid.ledger().mass)
    };
    let ((whole, mass), (half, half_mass)) = (run(false), run(true));
    assert!(whole.force[0] < -0.1);
    for a in 0..3 {
        assert!((whole.force[a] - half.force[a]).abs() < 1e-12, "{whole:?} {half:?}");
        assert!((whole.torque[a] - half.torque[a]).abs() < 1e-12, "{whole:?} {half:?}");
    }
    assert!((mass - 2.0 * half_mass).abs() < 1e-9);
}

/// A quarter of a duct around a quarter of a box, between two mirrors, gives the load on the whole
/// box: that in the whole duct, 1e-12 of the force. A part beside the mirrors keeps its own.
#[test]
fn a_part_that_mirrors_cut_counts_whole() {
    let loads = |quarter: bool| {
        let mut case = Case::new([14, 24, 24], [PERIODIC, WALL, WALL], 0.8);
        case.acceleration[0] = 1e-5;
        let mut scene = case.scene();
        let cuboid = |a: f64| Geometry::Box { size: [a; 3] };
        scene.parts.push(part("block", cuboid(6.6), [7.3, 12.0, 12.0]));
        scene.parts.push(part("beside", cuboid(2.6), [2.1, 4.4, 4.4]));
        if quarter {
            for axis in 1..3 {
                scene.domain.faces[axis][1] = Face::Symmetry;
                scene.domain.max[axis] = 12.0;
            }
        } else {
            // The images.
            for at in [[2.1, 19.6, 4.4], [2.1, 4.4, 19.6], [2.1, 19.6, 19.6]] {
                scene.parts.push(part(&format!("image {at:?}"), cuboid(2.6), at));
            }
        }
        let mut fluid = case.fluid_of(&scene);
        for _ in 0..200 {
            fluid.step(&[], &mut []).unwrap();
        }
        let mut loads = Vec::new();
        fluid.loads_on_parts(&mut loads);
        loads
    };
    let (whole, quarter) = (loads(false), loads(true));
    let scale = whole[0].force[0];
    assert!(scale > 1e-3 && whole[1].force[0] > 1e-4, "{whole:?}");
    for k in 0..2 {
        for a in 0..3 {
            let force = quarter[k].force[a] - whole[k].force[a];
            let torque = quarter[k].torque[a] - whole[k].torque[a];
            assert!(force.abs() < 1e-12 * scale, "{k} {a}: {quarter:?} {whole:?}");
            assert!(torque.abs() < 1e-11 * scale, "{k} {a}: {quarter:?} {whole:?}");
        }
    }
}
