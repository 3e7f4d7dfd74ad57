//! Tests of whole steps.

use super::*;
use crate::particles::seeding::seed;

fn settings<const D: usize>(gravity: [f64; D]) -> PicSettings<D> {
    PicSettings {
        density: 1000.0,
        gravity,
        transfer: Transfer::Blend { pic: 0.01 },
        surface: SurfaceOrder::Second,
        tolerance: Tolerance { relative: 1e-8, absolute: 1e-11, iterations: 100 },
        particles_per_axis: 2,
    }
}

/// Front of a collapsing column against Martin & Moyce 1952.
#[test]
fn dam_break_front() {
    let n: usize = std::env::var("N").map_or(40, |v| v.parse().unwrap());
    let a = 0.05715;
    let h = a / n as f64 * std::f64::consts::SQRT_2;
    let cells = [((10.0 * a) / h) as usize, (2.6 * a / h) as usize];
    let grid = StaggeredGrid::new(cells, a / (n as f64), [0.0; 2], [false; 2]);
    let grid = StaggeredGrid::new(
        [(10.0 * n as f64) as usize, (2.6 * n as f64) as usize],
        grid.spacing,
        [0.0; 2],
        [false; 2],
    );
    let mut solver = PicSolver::new(grid.clone(), settings([0.0, -9.81]), 1, |_, _| false).unwrap();
    seed(&grid, &mut solver.particles, 2, 0.5, 1, |x| x[0] < a && x[1] < 2.0 * a, |_| [0.0; 2]);
    let mut t = 0.0;
    let scale = (2.0 * 9.81 / a).sqrt();
    let mut next = 0.5;
    let mut forces = Vec::new();
    let begun = std::time::Instant::now();
    let mut updates = 0;
    let mut its = 0;
    let mut steps = 0;
    while t * scale < 8.0 {
        let dt = (0.5 * grid.spacing / solver.max_speed().max(0.1)).min(0.01 / scale * 4.0);
        let outcome = solver.step(dt, &[], &mut forces);
        assert!(outcome.converged, "{outcome:?}");
        updates += solver.depth.iter().filter(|&&d| d > 0.0).count();
        its += outcome.iterations;
        steps += 1;
        t += dt;
        if t * scale >= next {
            let front = solver.particles.position[0].iter().copied().fold(0.0, f64::max) / a;
            let mut xs = solver.particles.position[0].clone();
            xs.sort_by(f64::total_cmp);
            let wet = solver.depth.iter().filter(|&&d| d > 0.0).count();
            println!(
                "T {:.2} front {:.3} ({:.3}) speed {:.2} its {} wet {}",
                t * scale,
                front,
                xs[xs.len() - xs.len() / 500] / a,
                solver.max_speed(),
                outcome.iterations,
                wet as f64 / (2 * n * n) as f64
            );
            next += 0.5;
        }
    }
    println!(
        "{:.3} M wet cells/s, {:.1} iterations",
        updates as f64 / begun.elapsed().as_secs_f64() / 1e6,
        its as f64 / steps as f64
    );
}

/// A disc released at rest in the middle of a box.
#[test]
fn released_disc() {
    for ratio in [2.0, 0.5, 0.1, 0.01, 0.001] {
        let n = 200;
        let grid = StaggeredGrid::new([n, n], 1.0 / n as f64, [0.0; 2], [false; 2]);
        let mut solver =
            PicSolver::new(grid.clone(), settings([0.0, -9.81]), 1, |_, _| false).unwrap();
        let radius = 0.05;
        let mass = ratio * 1000.0 * std::f64::consts::PI * radius * radius;
        let body = RigidBody {
            centre: [0.503, 0.502],
            radius,
            velocity: [0.0; 2],
            mass: Some(mass),
            force: [0.0; 2],
        };
        let wet = |x: [f64; 2]| (x[0] - 0.503).hypot(x[1] - 0.502) > radius;
        seed(&grid, &mut solver.particles, 2, 0.0, 1, wet, |_| [0.0; 2]);
        let mut forces = Vec::new();
        let outcome = solver.step(1e-4, &[body], &mut forces);
        let got = forces[0][1] / mass - 9.81;
        // A square box: near enough to a round one of b = 10.
        let added = 1.02;
        let exact = -9.81 * (ratio - 1.0) / (ratio + added);
        println!("ratio {ratio}: {got} against {exact}: {:.4} {outcome:?}", got / exact);
    }
}
