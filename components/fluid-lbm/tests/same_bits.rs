//! The same bits from every set of vector instructions and any number of threads: moving, spinning
//! spheres that cover and uncover cells, walls, a periodic axis, a body force, rows that are no
//! whole number of vectors.

mod common;

use common::*;
use tremie_fluid_lbm::{Precision, Variant};
use tremie_messages::BodyState;

/// Every bit of loads, balance and populations of a run.
fn bits(precision: Precision, variant: Variant, threads: usize) -> Vec<u64> {
    let mut case = Case::new([37, 20, 18], [PERIODIC, WALL, PERIODIC], 0.65);
    case.precision = precision;
    case.variant = variant;
    case.threads = threads;
    case.average_force = true;
    case.acceleration = [2e-5, 0.0, -1e-5];
    case.velocity = [0.01, 0.0, 0.02];
    let mut fluid = case.fluid();
    let mut bodies: Vec<BodyState> = (0..9)
        .map(|id| {
            let at = [4.0 + 3.9 * id as f64, 5.0 + (id * 7 % 10) as f64, 2.0 * id as f64];
            let mut state = BodyState::at_rest(id, at);
            state.velocity = [0.01 * (id % 3) as f64, 0.01, -0.02];
            state.angular_velocity = [0.0, 0.003 * id as f64, 0.001];
            state
        })
        .collect();
    let events: Vec<_> = bodies.iter().map(|b| added(b.id, 1.2 + 0.3 * b.id as f64)).collect();
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
        let seen = fluid.diagnostics();
        assert!(seen.max_mach < 0.3);
        bits.extend([seen.max_speed, seen.min_density_deviation].map(f64::to_bits));
    }
    for cell in cells(&fluid) {
        if !fluid.node(cell).solid {
            bits.extend(fluid.populations_at(cell).map(f64::to_bits));
        }
    }
    bits
}

fn all_equal(precision: Precision) {
    let reference = bits(precision, Variant::Portable, 1);
    for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
        for threads in [1, 2, 3] {
            let found = bits(precision, variant, threads);
            assert!(found == reference, "{precision:?} {variant:?} {threads} threads");
        }
    }
}

#[test]
fn in_f64() {
    all_equal(Precision::F64);
}

#[test]
fn in_f32() {
    all_equal(Precision::F32);
}
