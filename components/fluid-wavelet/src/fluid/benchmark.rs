//! The gas by itself: a heap of pressure that runs apart, in a plane and in space.

use crate::domain::parameters::Parameters;
use crate::fluid::gas_fluid::GasFluid;
use std::collections::BTreeMap;
use std::time::Instant;
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Face, FluidMaterial, GasMaterial, GasRegion, Scene};
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Measurement, Quantity};

/// The heaps.
pub fn benchmarks(sizes: &BenchmarkSizes) -> Vec<Benchmark> {
    let mut cases = Vec::new();
    for &threads in &sizes.threads {
        for (dimensions, per_edge) in [(2, 4), (3, 1)] {
            // Blocks have 16 and 8 points.
            let n = (per_edge * sizes.edge).next_multiple_of(64);
            cases.push(Benchmark {
                name: format!("gas on wavelets, {dimensions} dimensions, finest {n} points"),
                threads,
                quantities: vec![
                    Quantity::new("", "M points x steps/s"),
                    Quantity::new("adaptation", "%"),
                    Quantity::new("transform", "%"),
                    Quantity::new("right-hand side", "%"),
                    Quantity::new("adaptation over right-hand side", "1"),
                ],
                make: Box::new(move || Ok(burst(dimensions, n, threads))),
            });
        }
    }
    cases
}

/// A cube, or a square, of `n` points of 10 mm with dense gas in its middle.
fn scene(dimensions: usize, n: usize) -> Scene {
    let edge = 0.01 * n as f64;
    let mut domain = Domain::new([0.0; 3], [edge; 3], Face::WALLS);
    domain.across = (dimensions == 2).then_some(1);
    let region = GasRegion {
        min: [0.4 * edge; 3],
        max: [0.6 * edge; 3],
        density: 2.4,
        pressure: 2e5,
        velocity: [0.0; 3],
    };
    let gas = GasMaterial {
        pressure: 1e5,
        temperature: 293.15,
        heat_ratio: 1.4,
        prandtl: 0.72,
        sutherland: 110.4,
        surface_temperatures: BTreeMap::new(),
        regions: vec![region],
        shock: None,
        vortex: None,
    };
    let fluid = FluidMaterial { gas: Some(gas), ..FluidMaterial::at_rest(1.2, 1.8e-5) };
    Scene { fluid: Some(fluid), ..Scene::empty(domain) }
}

fn burst(dimensions: usize, n: usize, threads: usize) -> Measurement {
    Box::new(move |seconds| {
        let scene = scene(dimensions, n);
        let parameters = Parameters::with_cell(0.01);
        let time_step = parameters.resolve(&scene).map_err(said)?.time_step;
        let mut fluid = GasFluid::new(&scene, &parameters, time_step, threads).map_err(said)?;
        fluid.start(&[], &mut []).map_err(|error| error.to_string())?;
        let (start, mut work) = (Instant::now(), 0);
        while start.elapsed().as_secs_f64() < seconds {
            fluid.advance(1, &[], &mut []).map_err(|error| error.to_string())?;
            work += fluid.work();
        }
        let rate = work as f64 * 1e-6 / start.elapsed().as_secs_f64();
        let times = fluid.times();
        let [adaptation, transform, rates, _] = times.shares().map(|share| 100.0 * share);
        Ok(vec![rate, adaptation, transform, rates, times.adaptation_over_rates()])
    })
}

fn said(problems: Vec<Problem>) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}
