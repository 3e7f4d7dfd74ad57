//! Pressure in gaps too narrow to hold a cell.

use crate::common::*;
use tremie_fluid_lbm::GapPressure::{self, Nearest, Zero};
use tremie_messages::scene::{Face, Geometry, Motion, Scene};
use tremie_messages::{BodyEvent, BodyState, Load};

const PRESSURE: f64 = 1e-3;

/// Loads on bodies and on parts that stand still after some steps in a fluid under pressure,
/// nothing moving; and the impulse that gaps gave.
fn pressed(
    gaps: GapPressure,
    change: impl Fn(&mut Scene),
    bodies: &[(BodyEvent, [f64; 3])],
) -> (Vec<Load>, Vec<Load>, [f64; 3]) {
    let mut case = Case::new([16, 16, 16], [WALL; 3], 0.8);
    case.gap_pressure = gaps;
    let mut scene = case.scene();
    scene.fluid.as_mut().unwrap().pressure = PRESSURE;
    for (name, size) in [("block", [6.0, 6.0, 4.0]), ("slab", [8.0, 8.0, 2.0])] {
        let mut block = part(name, Geometry::Box { size }, [0.0; 3]);
        block.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(block);
    }
    change(&mut scene);
    let mut fluid = case.fluid_of(&scene);
    let events: Vec<_> = bodies.iter().map(|(event, _)| *event).collect();
    let states: Vec<_> =
        bodies.iter().map(|(event, at)| BodyState::at_rest(event.id, *at)).collect();
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&states);
    fluid.start(&states, &mut loads).unwrap();
    for _ in 0..20 {
        fluid.step(&states, &mut loads).unwrap();
        closes(&fluid, 1e-12);
    }
    let mut on_parts = Vec::new();
    fluid.loads_on_parts(&mut on_parts);
    (loads, on_parts, fluid.ledger().gaps)
}

fn is_near(found: [f64; 3], expected: [f64; 3]) {
    for a in 0..3 {
        assert!((found[a] - expected[a]).abs() < 1e-13, "{found:?} {expected:?}");
    }
}

/// A block of 36 cells' footprint 0.3 cells above the floor feels the pressure on its underside
/// too, or does not; one that stands on it does not in either case: 1e-13.
#[test]
fn a_block_above_the_floor() {
    for (gaps, gap, expected) in [
        (Nearest, 0.3, 0.0),
        (Zero, 0.3, -36.0 * PRESSURE),
        (Nearest, 0.0, -36.0 * PRESSURE),
        (Zero, 0.0, -36.0 * PRESSURE),
    ] {
        let (loads, _, given) = pressed(gaps, |_| {}, &[(added_part(1, 0), [8.0, 7.0, 2.0 + gap])]);
        is_near(loads[0].force, [0.0, 0.0, expected]);
        is_near(loads[0].torque, [0.0; 3]);
        is_near(given, [0.0, 0.0, if gap > 0.0 { 36.0 * PRESSURE + expected } else { 0.0 }]);
    }
}

/// The same above a part that stands still, which feels what the block does not, at the right arm.
#[test]
fn a_block_above_a_part() {
    let table = |scene: &mut Scene| {
        let table = Geometry::Box { size: [10.0, 10.0, 4.0] };
        scene.parts.push(part("table", table, [7.0, 7.0, 5.0]));
    };
    let bodies = [(added_part(1, 0), [8.0, 8.0, 9.4])];
    let (loads, parts, _) = pressed(Nearest, table, &bodies);
    is_near(loads[0].force, [0.0; 3]);
    is_near(parts[0].force, [0.0; 3]);
    is_near(parts[0].torque, [0.0; 3]);
    let (loads, parts, _) = pressed(Zero, table, &bodies);
    is_near(loads[0].force, [0.0, 0.0, -36.0 * PRESSURE]);
    is_near(parts[0].force, [0.0, 0.0, 36.0 * PRESSURE]);
    // About the part's frame: the gap is a cell off along x and y.
    is_near(parts[0].torque, [36.0 * PRESSURE, -36.0 * PRESSURE, 0.0]);
}

/// Bodies across a gap from each other, spheres and parts, feel nothing in all and nothing each.
#[test]
fn bodies_near_each_other() {
    let pairs = [
        [(added_part(1, 0), [8.0, 8.0, 5.0]), (added_part(2, 1), [8.0, 8.0, 8.4])],
        [(added(1, 3.2), [6.1, 8.2, 8.0]), (added(2, 2.7), [12.1, 8.4, 8.1])],
        [(added(1, 3.2), [8.1, 8.2, 5.4]), (added_part(2, 1), [8.0, 8.0, 9.8])],
    ];
    for pair in pairs {
        let (with, _, given) = pressed(Nearest, |_| {}, &pair);
        let (without, ..) = pressed(Zero, |_| {}, &pair);
        is_near(given, [0.0; 3]);
        for k in 0..2 {
            is_near(with[k].force, [0.0; 3]);
            assert!(norm(without[k].force) > 0.05 * PRESSURE, "{:?}", without[k]);
        }
    }
}

/// A sphere on the floor, one near it, and one near it that a mirror cuts in half feel gauge
/// pressure only: nothing but what the touching cells hide.
#[test]
fn spheres_near_the_floor() {
    let mirror = |scene: &mut Scene| scene.domain.faces[0][0] = Face::Symmetry;
    for (x, change) in [(8.3, None), (0.0, Some(mirror))] {
        let change = |scene: &mut Scene| {
            if let Some(change) = change {
                change(scene);
            }
        };
        for gap in [0.0, 0.1, 0.2] {
            let sphere = [(added(1, 4.1), [x, 8.1, 4.1 + gap])];
            let (with, ..) = pressed(Nearest, change, &sphere);
            let (without, ..) = pressed(Zero, change, &sphere);
            is_near(with[0].force, [0.0; 3]);
            assert!(without[0].force[2] < -PRESSURE, "{:?}", without[0]);
        }
    }
}

/// A sphere and its image in a mirror have a gap between them, and so have two parts' images at an
/// edge of two mirrors: nothing acts.
#[test]
fn bodies_near_mirrors() {
    let mirrors = |scene: &mut Scene| {
        scene.domain.faces[0][0] = Face::Symmetry;
        scene.domain.faces[1][1] = Face::Symmetry;
    };
    for body in [
        (added(1, 4.1), [4.3, 8.1, 8.2]),
        (added(1, 4.1), [4.3, 11.8, 8.2]),
        (added_part(1, 0), [3.3, 12.6, 8.0]),
    ] {
        let (with, ..) = pressed(Nearest, mirrors, &[body]);
        let (without, ..) = pressed(Zero, mirrors, &[body]);
        is_near(with[0].force, [0.0; 3]);
        assert!(without[0].force[0] < -PRESSURE, "{:?}", without[0]);
    }
}
