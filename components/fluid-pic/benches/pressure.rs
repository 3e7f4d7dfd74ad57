//! Milliseconds of a solution of the pressure to 1e-8, in a tank with a wave on it and a lattice of
//! fixed round bodies that cut its cells. With a folder, the equations are written there.
//!
//! `cargo bench -p tremie-fluid-pic --no-default-features --bench pressure [-- FOLDER]`

use std::path::{Path, PathBuf};
use std::time::Instant;
use tremie_fluid_pic::{PicSettings, PicSolver, RigidBody, StaggeredGrid, Tolerance, seed};

/// Solutions of which the fastest counts.
const TIMES: usize = 5;
/// Bodies along each axis.
const BODIES: usize = 4;

fn bodies<const D: usize>(radius: f64) -> Vec<RigidBody<D>> {
    let centre = |mut number: usize| {
        std::array::from_fn(|_| {
            let along = number % BODIES;
            number /= BODIES;
            (along as f64 + 0.5) / BODIES as f64
        })
    };
    (0..BODIES.pow(D as u32)).map(|number| RigidBody::ball(centre(number), radius)).collect()
}

fn tank<const D: usize>(cells: usize, radius: f64, threads: usize) -> PicSolver<D> {
    let grid = StaggeredGrid::new([cells; D], 1.0 / cells as f64, [0.0; D], [false; D]);
    let gravity = std::array::from_fn(|a| if a + 1 == D { -9.81 } else { 0.0 });
    let mut settings = PicSettings::water(gravity);
    settings.tolerance = Tolerance { relative: 1e-8, absolute: 0.0, iterations: 100 };
    let mut solver = PicSolver::new(grid, settings, threads, Vec::new(), bodies(radius))
        .expect("threads of the system");
    let is_wet = |x: [f64; D]| x[D - 1] < 0.7 + 0.1 * (9.0 * x[0]).sin();
    seed(&solver.grid, &mut solver.particles, 2, 0.0, 1, is_wet, |x| {
        std::array::from_fn(|a| (5.0 * x[(a + 1) % D]).sin())
    });
    solver.remove_inside(&[]);
    solver.find_loads(1e-3, &[], &mut Vec::new());
    solver
}

fn measure<const D: usize>(cells: usize, radius: f64, folder: Option<&Path>) {
    for threads in [1, 2] {
        let mut solver = tank::<D>(cells, radius, threads);
        if let (1, Some(folder)) = (threads, folder) {
            write(&solver, &folder.join(format!("{D}d-{cells}")));
        }
        let mut fastest = f64::INFINITY;
        let mut iterations = 0;
        for _ in 0..TIMES {
            let start = Instant::now();
            let outcome = solver.solve_pressure_anew();
            fastest = fastest.min(start.elapsed().as_secs_f64());
            assert!(outcome.converged, "{outcome:?}");
            iterations = outcome.iterations;
        }
        let wet = solver.pressure_equations().right.len();
        println!(
            "{D}d-{cells} {threads} threads {:.2} ms {iterations} iterations {wet} cells",
            1e3 * fastest
        );
    }
}

/// Rows and columns, values and right side as raw numbers.
fn write<const D: usize>(solver: &PicSolver<D>, folder: &Path) {
    let equations = solver.pressure_equations();
    std::fs::create_dir_all(folder).expect("a folder that can be written");
    let doubles = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<_>>();
    let places: Vec<u8> = equations.places.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    for (name, bytes) in [
        ("places", places),
        ("values", doubles(&equations.values)),
        ("right", doubles(&equations.right)),
    ] {
        std::fs::write(folder.join(name), bytes).expect("a folder that can be written");
    }
}

fn main() {
    let folder = std::env::args().skip(1).find(|arg| !arg.starts_with("--")).map(PathBuf::from);
    for cells in [64, 128, 256, 512, 1024] {
        measure::<2>(cells, 0.08, folder.as_deref());
    }
    for cells in [32, 64, 128] {
        measure::<3>(cells, 0.1, folder.as_deref());
    }
}
