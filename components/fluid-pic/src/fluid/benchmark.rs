//! The particle fluid by itself: dam breaks in a plane and in space.

use crate::domain::parameters::Parameters;
use crate::fluid::pic_fluid::PicFluid;
use std::time::Instant;
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Face, Fill, FluidMaterial, Scene};
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Measurement, Quantity};

/// Cells along the domain for each of [`BenchmarkSizes::edge`]: in a plane, and in space.
const CELLS: [usize; 2] = [4, 1];

/// The dam breaks.
pub fn benchmarks(sizes: &BenchmarkSizes) -> Vec<Benchmark> {
    let mut cases = Vec::new();
    for &threads in &sizes.threads {
        for (dimensions, per_edge) in [2, 3].into_iter().zip(CELLS) {
            let n = (per_edge * sizes.edge).max(16);
            cases.push(Benchmark {
                name: format!("particle fluid, {dimensions} dimensions, dam break on {n} cells"),
                threads,
                quantities: vec![Quantity::new("", "M wet cells/s")],
                make: Box::new(move || Ok(collapse(dimensions, n, threads))),
            });
        }
    }
    cases
}

/// A column a quarter as wide as the domain and half as high, of `n` cells of 10 mm along x.
fn scene(dimensions: usize, n: usize) -> Scene {
    let edge = 0.01 * n as f64;
    let size = [edge, if dimensions == 2 { 1.0 } else { 0.25 * edge }, 0.5 * edge];
    let mut domain = Domain::new([0.0; 3], size, Face::WALLS);
    domain.across = (dimensions == 2).then_some(1);
    let max = [0.25 * edge, size[1], 0.4 * edge];
    let fill = vec![Fill { min: [0.0; 3], max, part: None, velocity: None }];
    let fluid = FluidMaterial { fill, ..FluidMaterial::at_rest(1000.0, 1e-3) };
    Scene { fluid: Some(fluid), gravity: [0.0, 0.0, -9.81], ..Scene::empty(domain) }
}

fn collapse(dimensions: usize, n: usize, threads: usize) -> Measurement {
    Box::new(move |seconds| {
        let scene = scene(dimensions, n);
        let parameters = Parameters::with_cell(0.01);
        let time_step = parameters.resolve(&scene).map_err(said)?.time_step;
        if dimensions == 2 {
            let fluid = PicFluid::plane(&scene, &parameters, time_step, threads).map_err(said)?;
            measured(fluid, seconds)
        } else {
            let fluid = PicFluid::new(&scene, &parameters, time_step, threads).map_err(said)?;
            measured(fluid, seconds)
        }
    })
}

fn said(problems: Vec<Problem>) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Millions of wet cells a second, from the start of the collapse on.
fn measured<const D: usize>(mut fluid: PicFluid<D>, seconds: f64) -> Result<Vec<f64>, String> {
    fluid.start(&[], &mut []).map_err(|error| error.to_string())?;
    let (start, mut cells) = (Instant::now(), 0);
    while start.elapsed().as_secs_f64() < seconds {
        fluid.advance(1, &[], &mut []).map_err(|error| error.to_string())?;
        cells += fluid.wet_cells();
    }
    Ok(vec![cells as f64 * 1e-6 / start.elapsed().as_secs_f64()])
}
