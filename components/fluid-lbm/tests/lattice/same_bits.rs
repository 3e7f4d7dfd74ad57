//! The same bits from every set of vector instructions and any number of threads: moving, spinning
//! spheres that cover and uncover cells, walls, a periodic axis, a body force, rows that are no
//! whole number of vectors; and again with mirrors, open faces, parts and a closure for turbulence.

use crate::common::*;
use tremie_fluid_lbm::{Collision, Precision, Refill, Variant};
use tremie_messages::BodyState;
use tremie_messages::scene::{Course, Face, Geometry, Motion, Outflow, Scene};

/// Adds turbulence, open faces, mirrors, and parts that stand and move.
fn enrich(case: &mut Case, scene: &mut Scene) {
    case.smagorinsky = 0.15;
    case.refill = Refill::Mass;
    let course = Course::default();
    scene.domain.faces[0] = [
        Face::Pressure { pressure: 1e-3, course: course.clone(), outflow: Outflow::Fixed },
        Face::Pressure { pressure: 0.0, course: course.clone(), outflow: Outflow::Absorbing },
    ];
    scene.domain.faces[1][1] =
        Face::Pressure { pressure: 0.0, course, outflow: Outflow::Convective };
    scene.domain.faces[2] = [Face::Symmetry, Face::Symmetry];
    let rod = Geometry::Cylinder { radius: 3.1, length: 40.0 };
    scene.parts.push(part("rod", rod, [30.2, 10.3, 9.0]));
    let mut stirrer = part("stirrer", Geometry::Box { size: [4.2, 1.3, 2.2] }, [0.0; 3]);
    stirrer.motion = Motion::Prescribed(Vec::new());
    scene.parts.push(stirrer);
}

/// Every bit of loads, balance and populations of a run.
fn bits(precision: Precision, variant: Variant, threads: usize, rich: bool) -> Vec<u64> {
    let mut case = Case::new([37, 20, 18], [PERIODIC, WALL, PERIODIC], 0.65);
    case.precision = precision;
    case.variant = variant;
    case.threads = threads;
    case.average_force = true;
    case.acceleration = [2e-5, 0.0, -1e-5];
    case.velocity = [0.01, 0.0, 0.02];
    let mut scene = case.scene();
    if rich {
        enrich(&mut case, &mut scene);
    }
    let mut fluid = case.fluid_of(&scene);
    let mut bodies: Vec<BodyState> = (0..9)
        .map(|id| {
            let at = [4.0 + 3.9 * id as f64, 5.0 + (id * 7 % 10) as f64, 2.0 * id as f64];
            let mut state = BodyState::at_rest(id, at);
            state.velocity = [0.01 * (id % 3) as f64, 0.01, -0.02];
            state.angular_velocity = [0.0, 0.003 * id as f64, 0.001];
            state
        })
        .collect();
    let mut events: Vec<_> = bodies.iter().map(|b| added(b.id, 1.2 + 0.3 * b.id as f64)).collect();
    if rich {
        let mut state = BodyState::at_rest(100, [17.3, 6.2, 9.1]);
        state.velocity = [0.02, 0.01, 0.0];
        bodies.push(state);
        events.push(added_part(100, 1));
    }
    fluid.apply_events(&events).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let mut bits = Vec::new();
    for _ in 0..60 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        let ledger = fluid.ledger();
        bits.extend(ledger.momentum.iter().chain([&ledger.mass]).map(|x| x.to_bits()));
        for load in &loads {
            bits.extend(load.force.iter().chain(&load.torque).map(|x| x.to_bits()));
        }
        let mut on_parts = Vec::new();
        fluid.loads_on_parts(&mut on_parts);
        for load in &on_parts {
            bits.extend(load.force.iter().chain(&load.torque).map(|x| x.to_bits()));
        }
        closes(&fluid, if precision == Precision::F64 { 1e-10 } else { 1e-2 });
        let seen = fluid.diagnostics();
        assert!(seen.max_mach < 0.3);
        bits.extend([seen.max_speed, seen.min_density_deviation, seen.max_tau].map(f64::to_bits));
    }
    for cell in cells(&fluid) {
        if !fluid.node(cell).solid {
            bits.extend(fluid.populations_at(cell).map(f64::to_bits));
        }
    }
    bits
}

/// Every bit of the balance and of the populations of a box whose rows end where lines of 64 bytes
/// do, with a sphere that moves at their end.
fn bits_of_rows(case: &Case) -> Vec<u64> {
    let mut fluid = case.fluid_of(&case.scene());
    let mut bodies = [BodyState::at_rest(1, [46.3, 2.7, 2.1])];
    bodies[0].velocity = [0.03, 0.01, -0.005];
    fluid.apply_events(&[added(1, 1.4)]).unwrap();
    let mut loads = loads_of(&bodies);
    fluid.start(&bodies, &mut loads).unwrap();
    let mut bits = Vec::new();
    for _ in 0..12 {
        advance(&mut bodies);
        fluid.step(&bodies, &mut loads).unwrap();
        let ledger = fluid.ledger();
        bits.extend(ledger.momentum.iter().chain([&ledger.mass]).map(|x| x.to_bits()));
        bits.extend(loads[0].force.map(f64::to_bits));
        closes(&fluid, if case.precision == Precision::F64 { 1e-10 } else { 1e-2 });
    }
    for cell in cells(&fluid) {
        if !fluid.node(cell).solid {
            bits.extend(fluid.populations_at(cell).map(f64::to_bits));
        }
    }
    bits
}

#[test]
fn where_rows_end_with_lines_in_every_kernel() {
    let course = Course::default();
    let open = Face::Pressure { pressure: 0.0, course, outflow: Outflow::Fixed };
    for face in [PERIODIC, WALL, Face::Symmetry, open] {
        for kernel in 0..40 {
            let has = |bit: u32| kernel >> bit & 1 == 1;
            let (collision, bulk) = [
                (Collision::Trt, None),
                (Collision::Bgk, None),
                (Collision::Trt, Some(1.0)),
                (Collision::Bgk, Some(0.9)),
                (Collision::CentralMoments, Some(1.0)),
            ][kernel >> 3];
            let mut case = Case::new([48, 6, 5], [face.clone(), WALL, PERIODIC], 0.6);
            case.lid = (1, [0.02, 0.0, 0.01]);
            (case.collision, case.bulk) = (collision, bulk);
            case.smagorinsky = if has(0) { 0.15 } else { 0.0 };
            case.acceleration = if has(1) { [2e-5, 0.0, -1e-5] } else { [0.0; 3] };
            case.precision = if has(2) { Precision::F32 } else { Precision::F64 };
            case.variant = Variant::Portable;
            let reference = bits_of_rows(&case);
            for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
                case.variant = variant;
                case.threads = 2;
                assert!(bits_of_rows(&case) == reference, "{face:?} {kernel:06b} {variant:?}");
            }
        }
    }
}

fn all_equal(precision: Precision, rich: bool) {
    let reference = bits(precision, Variant::Portable, 1, rich);
    for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
        for threads in [1, 2, 3] {
            let found = bits(precision, variant, threads, rich);
            assert!(found == reference, "{precision:?} {variant:?} {threads} threads");
        }
    }
}

#[test]
fn in_f64() {
    all_equal(Precision::F64, false);
}

#[test]
fn in_f32() {
    all_equal(Precision::F32, false);
}

#[test]
fn in_f64_with_everything() {
    all_equal(Precision::F64, true);
}

#[test]
fn in_f32_with_everything() {
    all_equal(Precision::F32, true);
}
