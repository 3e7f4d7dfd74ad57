//! Million wet cells a second of collapsing columns, in a plane and in space, by threads.
//!
//! `cargo bench -p tremie-fluid-pic --no-default-features --bench steps [-- 2|3]`

use std::time::Instant;
use tremie_fluid_pic::{PicSettings, PicSolver, StaggeredGrid, seed};

/// Steps that are timed.
const STEPS: usize = 60;

fn measure<const D: usize>(cells: [usize; D], threads: usize) {
    let edge = 0.01;
    let grid = StaggeredGrid::new(cells, edge, [0.0; D], [false; D]);
    let gravity = std::array::from_fn(|a| if a + 1 == D { -9.81 } else { 0.0 });
    let settings = PicSettings { relaxation: 0.1, ..PicSettings::water(gravity) };
    let mut solver =
        PicSolver::new(grid, settings, threads, Vec::new(), Vec::new()).expect("threads");
    let end = solver.grid.end();
    let is_wet = |x: [f64; D]| x[0] < 0.25 * end[0] && x[D - 1] < 0.8 * end[D - 1];
    seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |_| [0.0; D]);
    let dt = 0.5 * edge / (2.0 * 9.81 * 0.8 * end[D - 1]).sqrt();
    let mut loads = Vec::new();
    let (mut wet, mut iterations, mut took) = (0, 0, 0.0);
    for step in 0..STEPS + 20 {
        let start = Instant::now();
        let outcome = solver.step(dt, &[], &mut loads);
        // The first steps fill the caches, and are not typical.
        if step >= 20 {
            took += start.elapsed().as_secs_f64();
            wet += solver.wet_cells();
            iterations += outcome.iterations;
        }
    }
    println!(
        "{D}d {threads} threads {:.3} M wet cells/s, {:.1} iterations a step",
        1e-6 * wet as f64 / took,
        iterations as f64 / STEPS as f64
    );
}

fn main() {
    let only = std::env::args().nth(1).and_then(|arg| arg.parse::<usize>().ok());
    for threads in [1, 2] {
        if only != Some(3) {
            measure([512, 256], threads);
        }
        if only != Some(2) {
            measure([128, 32, 64], threads);
        }
    }
}
