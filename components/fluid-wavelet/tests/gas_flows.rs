//! Flows of a gas whose course is known.

use std::f64::consts::PI;
use tremie_fluid_wavelet::{DomainFace, Gas, GasState, WaveletSettings, WaveletSolver};

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
        WaveletSolver::new(settings, 2, |x| wind(vortex(x[0], x[1]))).expect("threads");
    let mass = solver.integral(0);
    while solver.time < time {
        let dt = solver.longest_step().min(time - solver.time);
        solver.step(dt).expect("gas");
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
    let (gamma, star, speed) = (1.4_f64, 0.303_130_178, 0.927_452_620);
    let (left, right) = (0.426_319_428, 0.265_573_711);
    let sound = gamma.sqrt();
    let tail = speed - sound * (star as f64).powf((gamma - 1.0) / (2.0 * gamma));
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
        roots: [1, 1, 1],
        coarsest: 1.0 / 16.0,
        deepest,
        faces: [[DomainFace::Open; 2]; 3],
        ..WaveletSettings::new(1, gas)
    };
    let initial = |x: [f64; 3]| {
        let (density, pressure) = if x[0] < 0.5 { (1.0, 1.0) } else { (0.125, 0.1) };
        GasState { density, velocity: [0.0; 3], pressure }
    };
    let mut solver = WaveletSolver::new(settings, 1, initial).expect("threads");
    while solver.time < 0.2 {
        let dt = solver.longest_step().min(0.2 - solver.time);
        solver.step(dt).expect("gas");
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
