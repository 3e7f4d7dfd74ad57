//! Million points times steps a second of a gas, on adaptive and on whole grids, by threads.
//!
//! `cargo bench -p tremie-fluid-wavelet --bench gas_steps`

use std::time::Instant;
use tremie_fluid_wavelet::{Ball, Gas, GasState, WaveletSettings, WaveletSolver};

/// No bodies.
const NONE: &[Ball] = &[];

/// Steps that are timed.
const STEPS: usize = 24;

fn measure(dims: usize, deepest: u8, tolerance: f64, reynolds: Option<f64>, threads: usize) {
    let gas = Gas::scaled(reynolds);
    let settings = WaveletSettings {
        roots: [2; 3],
        coarsest: if dims < 3 { 1.0 / 32.0 } else { 1.0 / 16.0 },
        deepest,
        tolerance,
        ..WaveletSettings::new(dims, gas)
    };
    let initial = |x: [f64; 3]| {
        let square: f64 = (0..dims).map(|a| (x[a] - 0.5).powi(2)).sum();
        let heap = 1.0 + 0.2 * (-200.0 * square).exp();
        GasState { density: heap, velocity: [0.1, -0.2, 0.05], pressure: heap / 1.4 }
    };
    let mut solver = WaveletSolver::new(settings, threads, NONE, initial).expect("threads");
    let (mut points, mut took) = (0, 0.0);
    for step in 0..STEPS + 4 {
        let start = Instant::now();
        let dt = solver.longest_step();
        solver.step(dt, NONE).expect("gas");
        if step >= 4 {
            took += start.elapsed().as_secs_f64();
            points += solver.points();
        }
    }
    println!(
        "{dims}d {} {threads} threads: {:.3} M points x steps/s, {:.1} % of {} levels",
        if reynolds.is_some() { "viscous" } else { "inviscid" },
        1e-6 * points as f64 / took,
        100.0 * solver.share_of_full_grid(),
        deepest
    );
}

fn main() {
    for threads in [1, 2] {
        for reynolds in [None, Some(1000.0)] {
            measure(2, 5, 1e-4, reynolds, threads);
            measure(3, 3, 1e-3, reynolds, threads);
        }
    }
    measure(2, 3, 0.0, Some(1000.0), 1);
}
