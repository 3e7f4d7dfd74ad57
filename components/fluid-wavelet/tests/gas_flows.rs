//! Flows of a gas whose course is known.

use std::f64::consts::PI;
use tremie_fluid_wavelet::{Ball, DomainFace, Gas, GasState, WaveletSettings, WaveletSolver};

/// No bodies.
const NONE: &[Ball] = &[];

/// The isentropic vortex of strength 5 (Shu 1998), at a distance from its middle, without the wind.
fn vortex(x: f64, y: f64) -> GasState {
    let (gamma, strength) = (1.4, 5.0);
    let fall = (1.0 - x * x - y * y).exp();
    let heat = 1.0 - (gamma - 1.0) * strength * strength / (8.0 * gamma * PI * PI) * fall;
    let density = heat.powf(1.0 / (gamma - 1.0));
    let turn = strength / (2.0 * PI) * fall.sqrt();
    GasState { density, velocity: [-turn * y, turn * x, 0.0], pressure: density * heat }
}

/// The largest error of the density, the mass lost, and the points, after the vortex has gone a way.
fn carried_vortex(deepest: u8, tolerance: f64, time: f64) -> (f64, f64, usize) {
    let settings = WaveletSettings {
        roots: [1, 1, 1],
        coarsest: 10.0 / 16.0,
        origin: [-5.0, -5.0, 0.0],
        deepest,
        tolerance,
        ..WaveletSettings::new(2, Gas { gas_constant: 1.0, ..Gas::scaled(None) })
    };
    let wind = |mut state: GasState| {
        state.velocity[0] += 1.0;
        state.velocity[1] += 1.0;
        state
    };
    let mut solver =
        WaveletSolver::new(settings, 2, NONE, |x| wind(vortex(x[0], x[1]))).expect("threads");
    let mass = solver.integral(0);
    while solver.time < time {
        let dt = solver.longest_step().min(time - solver.time);
        solver.step(dt, NONE).expect("gas");
    }
    let mut error = 0.0_f64;
    solver.for_each_point(|_, at, fields| {
        let wrapped = |x: f64| (x - time + 5.0).rem_euclid(10.0) - 5.0;
        let exact = vortex(wrapped(at[0]), wrapped(at[1]));
        error = error.max((fields[0] - exact.density).abs());
    });
    let lost = (solver.integral(0) / mass - 1.0).abs();
    (error, lost, solver.points())
}

#[test]
fn a_vortex_is_carried_to_fourth_order() {
    // The whole grid: a tolerance that all details exceed near the vortex.
    let [coarse, fine] = [2, 3].map(|deepest| carried_vortex(deepest, 1e-9, 2.0));
    let order = (coarse.0 / fine.0).log2();
    println!("errors {coarse:?} {fine:?}, order {order:.2}");
    assert!(order > 3.5, "errors {coarse:?}, {fine:?}: order {order}");
}

#[test]
fn the_error_of_a_vortex_follows_the_tolerance() {
    for tolerance in [1e-2, 1e-3, 1e-4] {
        let (error, lost, points) = carried_vortex(4, tolerance, 2.0);
        println!("tolerance {tolerance}: error {error:.2e}, mass lost {lost:.1e}, {points} points");
        assert!(error < 10.0 * tolerance, "tolerance {tolerance}: error {error}");
        assert!(lost < 2.0 * tolerance, "tolerance {tolerance}: mass lost {lost}");
    }
}

/// Density of Sod's shock tube after a time, at a distance from the diaphragm.
fn sod(x: f64, time: f64) -> f64 {
    // Pressure and speed between the waves (Toro 2009, Table 4.2).
    let (gamma, star, speed) = (1.4_f64, 0.303_130_178_f64, 0.927_452_620);
    let (left, right) = (0.426_319_428, 0.265_573_711);
    let sound = gamma.sqrt();
    let tail = speed - sound * star.powf((gamma - 1.0) / (2.0 * gamma));
    let shock = (gamma * 0.1 / 0.125).sqrt()
        * ((gamma + 1.0) / (2.0 * gamma) * star / 0.1 + (gamma - 1.0) / (2.0 * gamma)).sqrt();
    let along = x / time;
    if along < -sound {
        1.0
    } else if along < tail {
        let factor = 2.0 / (gamma + 1.0) - (gamma - 1.0) / ((gamma + 1.0) * sound) * along;
        factor.powf(2.0 / (gamma - 1.0))
    } else if along < speed {
        left
    } else if along < shock {
        right
    } else {
        0.125
    }
}

/// Mean error of the density in Sod's tube at 0.2, and the points.
fn shock_tube(deepest: u8) -> (f64, usize) {
    let gas = Gas { gas_constant: 1.0, ..Gas::scaled(None) };
    let settings = WaveletSettings {
        block_edge: 8,
        roots: [2, 1, 1],
        coarsest: 1.0 / 16.0,
        deepest,
        faces: [[DomainFace::Open; 2]; 3],
        ..WaveletSettings::new(1, gas)
    };
    let initial = |x: [f64; 3]| {
        let (density, pressure) = if x[0] < 0.5 { (1.0, 1.0) } else { (0.125, 0.1) };
        GasState { density, velocity: [0.0; 3], pressure }
    };
    let mut solver = WaveletSolver::new(settings, 1, NONE, initial).expect("threads");
    while solver.time < 0.2 {
        let dt = solver.longest_step().min(0.2 - solver.time);
        solver.step(dt, NONE).expect("gas");
    }
    let mut error = 0.0;
    solver.for_each_point(|block, at, fields| {
        let spacing = solver.settings.spacing(block.level);
        error += spacing * (fields[0] - sod(at[0] - 0.5, 0.2)).abs();
    });
    (error, solver.points())
}

#[test]
fn a_shock_tube_is_resolved_with_few_points() {
    let [coarse, fine] = [4, 6].map(shock_tube);
    println!("errors {coarse:?} {fine:?}");
    assert!(coarse.0 < 8e-3 && fine.0 < 2.5e-3, "errors {coarse:?} {fine:?}");
    assert!(fine.1 < 1024 / 2, "{} points", fine.1);
}

/// Pressure behind a normal shock, over that ahead (Rankine and Hugoniot).
fn shock_pressure(mach: f64) -> f64 {
    1.0 + 2.8 / 2.4 * (mach * mach - 1.0)
}

/// Pressure at a mirror off which a shock has come back, over that ahead of the shock.
fn reflected_pressure(mach: f64) -> f64 {
    let behind = shock_pressure(mach);
    behind * ((3.0 * 1.4 - 1.0) * behind - 0.4) / (0.4 * behind + 2.4)
}

#[test]
fn a_shock_comes_back_from_a_wall() {
    for (mach, known) in [(1.3, 3.108), (1.7, 8.579), (2.81, 42.90)] {
        let gas = Gas::scaled(None);
        let ahead = 1.0 / 1.4;
        let ratio = 2.4 * mach * mach / (0.4 * mach * mach + 2.0);
        let speed = mach * (1.0 - 1.0 / ratio);
        let behind = GasState {
            density: ratio,
            velocity: [speed, 0.0, 0.0],
            pressure: ahead * shock_pressure(mach),
        };
        let still = GasState { density: 1.0, velocity: [0.0; 3], pressure: ahead };
        for is_turned in [false, true] {
            let given = |state: GasState| DomainFace::Given(gas.fields(1, state));
            let turned = GasState { velocity: [-speed, 0.0, 0.0], ..behind };
            let ends = if is_turned {
                [DomainFace::Mirror, given(turned)]
            } else {
                [given(behind), DomainFace::Mirror]
            };
            let settings = WaveletSettings {
                block_edge: 8,
                roots: [2, 1, 1],
                coarsest: 1.0 / 16.0,
                deepest: 5,
                faces: [ends, [DomainFace::Periodic; 2], [DomainFace::Periodic; 2]],
                ..WaveletSettings::new(1, gas)
            };
            let is_behind = |x: f64| if is_turned { x > 0.75 } else { x < 0.25 };
            let of_behind = if is_turned { turned } else { behind };
            let initial = |x: [f64; 3]| if is_behind(x[0]) { of_behind } else { still };
            let mut solver = WaveletSolver::new(settings, 1, NONE, initial).expect("threads");
            // The shock reaches the wall at 0.75/mach, and comes half of the way back.
            let end = 0.75 / mach + 0.2;
            while solver.time < end {
                let dt = solver.longest_step().min(end - solver.time);
                solver.step(dt, NONE).expect("gas");
            }
            let mut at_wall = (f64::INFINITY, 0.0);
            solver.for_each_point(|_, at, fields| {
                let distance = (at[0] - if is_turned { 0.02 } else { 0.98 }).abs();
                if distance < at_wall.0 {
                    at_wall = (distance, gas.state(1, &fields).pressure / ahead);
                }
            });
            let exact = reflected_pressure(mach);
            println!("Mach {mach}: {} at the wall, exact {exact}", at_wall.1);
            assert!((exact / known - 1.0).abs() < 2e-4, "{exact}");
            assert!((at_wall.1 / exact - 1.0).abs() < 0.01, "Mach {mach}: {}", at_wall.1);
        }
    }
}

#[test]
fn a_shear_wave_dies_as_its_viscosity_says() {
    let gas = Gas::scaled(Some(100.0));
    let settings = WaveletSettings {
        coarsest: 1.0 / 16.0,
        deepest: 1,
        tolerance: 1e-6,
        ..WaveletSettings::new(2, gas)
    };
    let wave = 2.0 * PI;
    let initial = |x: [f64; 3]| GasState {
        density: 1.0,
        velocity: [0.0, 0.01 * (wave * x[0]).sin(), 0.0],
        pressure: 1.0 / 1.4,
    };
    let mut solver = WaveletSolver::new(settings, 2, NONE, initial).expect("threads");
    while solver.time < 0.5 {
        let dt = solver.longest_step().min(0.5 - solver.time);
        solver.step(dt, NONE).expect("gas");
    }
    let mut largest = 0.0_f64;
    solver.for_each_point(|_, _, fields| largest = largest.max(fields[2] / fields[0]));
    let exact = 0.01 * (-wave * wave * 0.01 * 0.5).exp();
    assert!((largest / exact - 1.0).abs() < 1e-3, "{largest} for {exact}");
}

/// A pulse of pressure beside the middle of a box, after some steps: densities and places.
fn pulse(dims: usize, threads: usize, axes: [usize; 3]) -> Vec<([u64; 3], u64)> {
    let gas = Gas::scaled(Some(500.0));
    let settings = WaveletSettings {
        block_edge: 8,
        coarsest: 1.0 / 8.0,
        deepest: 2,
        ..WaveletSettings::new(dims, gas)
    };
    let initial = |x: [f64; 3]| {
        let square: f64 = (0..dims).map(|a| (x[axes[a]] - [0.5, 0.4, 0.45][a]).powi(2)).sum();
        let pressure = (1.0 + 0.5 * (-80.0 * square).exp()) / 1.4;
        GasState { density: 1.0, velocity: [0.0; 3], pressure }
    };
    let mut solver = WaveletSolver::new(settings, threads, NONE, initial).expect("threads");
    for _ in 0..10 {
        let dt = solver.longest_step();
        solver.step(dt, NONE).expect("gas");
    }
    let mut found = Vec::new();
    solver.for_each_point(|_, at, fields| {
        found.push((std::array::from_fn(|a| at[axes[a]].to_bits()), fields[0].to_bits()));
    });
    found
}

#[test]
fn threads_do_not_change_a_bit() {
    for dims in [2, 3] {
        let alone = pulse(dims, 1, [0, 1, 2]);
        for threads in [2, 8] {
            assert!(pulse(dims, threads, [0, 1, 2]) == alone, "{dims}-d, {threads} threads");
        }
    }
}

#[test]
fn a_pulse_is_the_same_along_any_axis() {
    let straight: std::collections::HashMap<_, _> = pulse(3, 2, [0, 1, 2]).into_iter().collect();
    let turned = pulse(3, 2, [1, 2, 0]);
    assert_eq!(straight.len(), turned.len());
    for (at, density) in turned {
        let [density, other] = [density, straight[&at]].map(f64::from_bits);
        assert!((density - other).abs() < 1e-13, "{density} {other}");
    }
}
