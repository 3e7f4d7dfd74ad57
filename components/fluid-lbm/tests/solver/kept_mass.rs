//! Closed boxes keep their mass, or say what is lost.

use crate::common::*;
use tremie_fluid_lbm::{Collision, LbmFluid, Precision, Refill, Walls};
use tremie_messages::BodyState;
use tremie_messages::scene::{
    Course, Face, Geometry, Motion, Outflow, PartBoundary, Probe, ProbeShape, Scene,
};

/// Share of the mass that a fluid without bodies gains in so many steps; what it says to have lost
/// is that.
fn gain(fluid: &mut LbmFluid, steps: usize) -> f64 {
    let first = fluid.ledger();
    let mass = first.mass + first.mass_lost;
    for step in 0..steps {
        fluid.step(&[], &mut []).unwrap();
        if step % 100 == 3 {
            // To rounding of the storage.
            closes(fluid, 1e-6);
        }
    }
    let ledger = fluid.ledger();
    assert!((mass - ledger.mass - ledger.mass_lost).abs() < 1e-13 * mass, "{ledger:?}");
    ledger.mass / first.mass - 1.0
}

/// A wall that slides pushes fluid into one edge and takes it out of the other, where the density
/// is another. On each face in turn, and on two that meet: in f64 the mass stays to 1e-13 in 800
/// steps, in f32 to 1e-7 (rounding of the collision).
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
                scene.domain.faces[axis][side] = Face::moving(velocity(axis));
            }
            let mut fluid = case.fluid_of(&scene);
            let gained = gain(&mut fluid, 800);
            let scheme = format!("{lids:?} {:?} {:?}", case.collision, case.walls);
            println!("{scheme} {:?}: {gained:e}", case.precision);
            assert!(gained.abs() < bound, "{scheme} {:?}: {gained}", case.precision);
            assert!(fluid.diagnostics().max_speed > 0.02, "{scheme}");
        }
    }
}

/// A block that stands aslant and a ball under a lid: half-way walls keep the mass, interpolated
/// ones to 1e-13 with what they owe. That does not grow.
#[test]
fn still_walls_keep_the_mass() {
    for walls in [Walls::Halfway, Walls::Bouzidi] {
        let mut case = Case::new([22, 20, 18], [WALL; 3], 0.6);
        case.walls = walls;
        case.lid = (2, [0.05, 0.02, 0.0]);
        let mut scene = case.scene();
        let mut block = part("block", Geometry::Box { size: [5.3, 4.1, 6.2] }, [7.3, 8.1, 9.2]);
        block.pose.orientation = [0.1, 0.3, 0.2, (1.0_f64 - 0.14).sqrt()];
        scene.parts.push(block);
        scene.parts.push(part("ball", Geometry::Sphere { radius: 3.4 }, [14.2, 11.7, 7.1]));
        let mut fluid = case.fluid_of(&scene);
        let mut last = f64::NAN;
        for steps in [2000, 2000, 6000] {
            gain(&mut fluid, steps);
            let ledger = fluid.ledger();
            last = ledger.mass_parts / ledger.mass;
            println!("{walls:?}: in the last step {last:e}");
            let owed = ledger.mass_owed / ledger.mass;
            println!("{walls:?}: owed {owed:e}, lost {:e}", ledger.lost_share());
            assert!(
                (ledger.mass_lost - ledger.mass_owed).abs() < 1e-13 * ledger.mass,
                "{ledger:?}"
            );
            match walls {
                Walls::Halfway => assert!(owed.abs() < 1e-13, "{owed}"),
                Walls::Bouzidi => assert!((1e-8..1e-4).contains(&owed.abs()), "{owed}"),
            }
        }
        assert!(last.abs() < 1e-13, "the flow is steady: {last}");
    }
}

/// A plate that covers no cell, standing aslant under a lid, makes and takes nothing in any step,
/// nor has it anything to pay: to 1e-13 of the fluid's mass. Neither does it where a ball passes
/// that covers the cells at one side of its edge.
#[test]
fn a_thin_plate_keeps_the_mass_in_each_step() {
    let mut case = Case::new([22, 20, 18], [WALL; 3], 0.6);
    case.refill = Refill::Mass;
    case.lid = (2, [0.05, 0.02, 0.0]);
    let mut scene = case.scene();
    let mut plate = part("plate", Geometry::Box { size: [8.3, 7.1, 0.01] }, [9.13, 9.4, 9.66]);
    plate.pose.orientation = [0.1, 0.3, 0.2, (1.0_f64 - 0.14).sqrt()];
    scene.parts.push(plate);
    let mut fluid = case.fluid_of(&scene);
    assert_eq!(fluid.diagnostics().fluid_cells, 22 * 20 * 18);
    fluid.apply_events(&[added(1, 2.3)]).unwrap();
    let mut bodies = vec![BodyState::at_rest(1, [16.0, 9.3, 5.0])];
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    bodies[0].velocity = [-0.01, 0.0, 0.002];
    let mut moved = 0.0_f64;
    for step in 0..1000 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        let ledger = fluid.ledger();
        let made = ledger.mass_parts / ledger.mass;
        assert!(made.abs() < 1e-13, "{made:e} in step {step}");
        moved = moved.max(norm(ledger.parts));
    }
    assert!(moved > 1e-4, "{moved}");
}

/// A tube aslant between a face at a pressure and one without.
fn tube(case: &Case) -> Scene {
    let mut scene = case.scene();
    let face =
        |pressure| Face::Pressure { pressure, course: Course::default(), outflow: Outflow::Fixed };
    scene.domain.faces[2] = [face(2e-4), face(0.0)];
    let mut tube =
        part("tube", Geometry::Cylinder { radius: 4.3, length: 90.0 }, [13.0, 6.0, 22.0]);
    tube.cavity = true;
    let half = 0.13_f64;
    tube.pose.orientation = [0.0, half.sin(), 0.0, half.cos()];
    scene.parts.push(tube);
    scene
}

/// The fluid that flows into a tube comes out of it, with interpolated walls as with half-way ones;
/// the mass that these owe meanwhile is told. Patches of wall pay where they owe: sections between
/// them agree.
#[test]
fn a_tube_loses_nothing() {
    for (walls, bound) in [(Walls::Halfway, 1e-8), (Walls::Bouzidi, 1e-3)] {
        let mut case = Case::new([26, 12, 44], [WALL; 3], 0.9);
        case.walls = walls;
        let mut scene = tube(&case);
        // Two patches of 8 layers, near the ends.
        for layer in (6..14).chain(30..38) {
            let (min, max) = ([0.0; 3], [26.0, 12.0, 44.0]);
            let position = f64::from(layer) + 0.5;
            let shape = ProbeShape::Section { axis: 2, position, min, max };
            scene.probes.push(Probe { name: format!("section{layer}"), shape });
        }
        let mut fluid = case.fluid_of(&scene);
        (0..4000).for_each(|_| fluid.step(&[], &mut []).unwrap());
        let before = fluid.ledger();
        fluid.restart_means();
        let mut came = 0.0;
        for _ in 0..500 {
            fluid.step(&[], &mut []).unwrap();
            came += fluid.ledger().mass_open;
        }
        let after = fluid.ledger();
        let lost = after.mass_lost - before.mass_lost;
        println!("{walls:?}: lost {lost:e}, came {came:e} of {}", after.mass);
        assert!((lost - (came - (after.mass - before.mass))).abs() < 1e-12 * after.mass);
        let mut found = Vec::new();
        fluid.probes(&mut found);
        let rates: Vec<f64> = found.chunks(3).map(|section| section[2]).collect();
        let [near, far] = [&rates[..8], &rates[8..]].map(|rates| rates.iter().sum::<f64>() / 8.0);
        println!("{walls:?}: {near:e} and {far:e} pass: {rates:?}");
        let spread = rates.iter().map(|rate| (rate / near - 1.0).abs()).fold(0.0, f64::max);
        assert!(near > 1e-3 && (far / near - 1.0).abs() < bound, "{near} {far}");
        assert!(spread < 0.01, "between the layers of a step of the wall: {spread}");
        match walls {
            Walls::Halfway => assert!(after.lost_share() < 1e-13, "{after:?}"),
            Walls::Bouzidi => {
                assert!(lost.abs() < 1e-10 * after.mass, "{lost} {came}");
                assert!(after.mass_owed.abs() > 1e-9 * after.mass, "{after:?}");
            }
        }
    }
}

/// The fluid that a part lets through is not lost.
#[test]
fn what_a_part_lets_through_is_not_lost() {
    for inlet in [
        PartBoundary::Velocity { velocity: [0.0, 0.0, 0.01], course: Course::default() },
        PartBoundary::Pressure { pressure: 1e-4, course: Course::default() },
    ] {
        let mut case = Case::new([12, 12, 20], [WALL; 3], 0.8);
        case.walls = Walls::Halfway;
        let mut scene = case.scene();
        scene.domain.faces[2][1] =
            Face::Pressure { pressure: 0.0, course: Course::default(), outflow: Outflow::Fixed };
        let mut source = part("source", Geometry::Box { size: [12.0, 12.0, 3.0] }, [6.0, 6.0, 1.5]);
        source.boundary = inlet.clone();
        scene.parts.push(source);
        scene.parts.push(part("ball", Geometry::Sphere { radius: 2.3 }, [6.2, 5.7, 10.1]));
        let mut fluid = case.fluid_of(&scene);
        let mut came = 0.0;
        for _ in 0..1000 {
            fluid.step(&[], &mut []).unwrap();
            came += fluid.ledger().mass_parts;
        }
        let ledger = fluid.ledger();
        println!("{inlet:?}: {came} came, {:e} lost", ledger.mass_lost);
        assert!(came > 1.0 && ledger.lost_share() < 1e-13, "{came} {ledger:?}");
    }
}

/// Spheres and a part that turns as it moves, under a lid: what is said to be lost is what is
/// missing at the mean density. With `refill = "mass"` and walls half-way it is what is owed. A
/// sphere that vanishes or appears loses nothing.
#[test]
fn what_bodies_lose_is_told() {
    for (refill, walls) in [
        (Refill::Eqneq, Walls::Bouzidi),
        (Refill::Mass, Walls::Bouzidi),
        (Refill::Eqneq, Walls::Halfway),
        (Refill::Mass, Walls::Halfway),
    ] {
        let mut case = Case::new([30, 22, 24], [WALL; 3], 0.6);
        (case.refill, case.walls) = (refill, walls);
        case.lid = (2, [0.04, 0.0, 0.0]);
        let mut scene = case.scene();
        let mut bar = part("bar", Geometry::Box { size: [8.0, 3.2, 4.3] }, [0.0; 3]);
        bar.motion = Motion::Prescribed(Vec::new());
        scene.parts.push(bar);
        scene.parts.push(part("ball", Geometry::Sphere { radius: 3.2 }, [24.2, 5.1, 5.7]));
        let mut fluid = case.fluid_of(&scene);
        fluid.apply_events(&[added(1, 3.5), added_part(2, 0), added(3, 2.6)]).unwrap();
        let at = [[7.3, 6.0, 8.6], [10.1, 12.3, 16.2], [22.0, 15.5, 6.0]];
        let mut bodies: Vec<_> =
            (1..4).zip(at).map(|(id, at)| BodyState::at_rest(id, at)).collect();
        let mut loads = loads_of(&bodies);
        fluid.start(&bodies, &mut loads).unwrap();
        let cells = |fluid: &LbmFluid| fluid.diagnostics().fluid_cells as f64;
        let (mass, first) = (fluid.ledger().mass, cells(&fluid));
        bodies[1].angular_velocity = [0.0, 2e-3, 0.0];
        let (mut most, mut apart) = (0.0_f64, 0.0_f64);
        for step in 0..1200 {
            let angle = 1e-3 * f64::from(step + 1);
            bodies[1].orientation = [0.0, angle.sin(), 0.0, angle.cos()];
            let way = if step / 300 % 2 == 0 { 1.0 } else { -1.0 };
            bodies[0].velocity = [0.01 * way, 0.004 * way, 0.0];
            bodies[1].velocity = [0.02 * way, 0.0, 0.0];
            advance(&mut bodies);
            fluid.step(&bodies, &mut loads).unwrap();
            let ledger = fluid.ledger();
            let missing = mass - ledger.mass * first / cells(&fluid);
            most = most.max(missing.abs());
            apart = apart.max((missing - ledger.mass_lost).abs());
            if refill == Refill::Mass && walls == Walls::Halfway {
                assert!((ledger.mass_lost - ledger.mass_owed).abs() < 1e-12 * mass, "{ledger:?}");
            }
        }
        println!("{refill:?} {walls:?}: lost {most} of {mass}, apart {apart:e}");
        assert!(apart < 1e-11 * mass, "{refill:?} {walls:?} {apart}");
        assert!(most > 0.01, "{refill:?} {walls:?} {most}");
        let told = fluid.ledger().mass_lost;
        fluid.apply_events(&[removed(3)]).unwrap();
        bodies.pop();
        loads.pop();
        fluid.step(&bodies, &mut loads).unwrap();
        fluid.apply_events(&[added(4, 2.6)]).unwrap();
        bodies.push(BodyState::at_rest(4, [22.0, 15.5, 16.0]));
        loads.push(loads[0]);
        fluid.step(&bodies, &mut loads).unwrap();
        assert!((fluid.ledger().mass_lost - told).abs() < 0.1, "{told} {:?}", fluid.ledger());
    }
}
