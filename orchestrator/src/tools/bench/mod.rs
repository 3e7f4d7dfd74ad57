//! Benchmarks of Tremie on this machine: `tremie bench`.
//!
//! Shared machines drift, so seconds of one moment say little of another. Each case is measured
//! several times. Before each time the memory's bandwidth is measured, with as many threads. The
//! results are the median, the range, and a kernel's share of that bandwidth. [`memory`] measures
//! the bandwidth, each built-in component brings benchmarks of its own, and [`coupled`] measures
//! whole runs by this very program.

pub mod coupled;
pub mod memory;

use crate::registry::BUILT_IN;
use memory::Stream;
use serde::Serialize;
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes, Quantity};

/// Choice of benchmarks, their sizes, and the length of measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchmarkPlan {
    /// Words that the names of benchmarks must have.
    pub words: Vec<String>,
    /// Threads, and cells along an edge.
    pub sizes: BenchmarkSizes,
    /// Measurements of each benchmark.
    pub repeats: usize,
    /// Length of a measurement, about [s].
    pub seconds: f64,
}

/// Result of a quantity of a benchmark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BenchmarkRow {
    /// The case.
    pub case: String,
    /// Threads; 0 where that has no meaning.
    pub threads: usize,
    /// The quantity.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// Median of the measurements.
    pub median: f64,
    /// The least and the greatest of them.
    pub range: [f64; 2],
    /// Median of the share of the bandwidth in place that it took, measured in turn with it.
    pub share: Option<f64>,
}

/// All benchmarks that the plan's words choose, in order.
pub fn benchmarks(plan: &BenchmarkPlan) -> Vec<Benchmark> {
    let mut all = memory::benchmarks(&plan.sizes.threads);
    all.extend(BUILT_IN.iter().flat_map(|component| (component.benchmarks)(&plan.sizes)));
    all.extend(coupled::benchmarks());
    let wanted = |benchmark: &Benchmark| {
        let threads = match benchmark.threads {
            0 => String::new(),
            1 => "1 thread".into(),
            threads => format!("{threads} threads"),
        };
        plan.words.iter().all(|word| benchmark.name.contains(word) || threads.contains(word))
    };
    all.retain(wanted);
    all
}

/// Measures a benchmark.
///
/// # Errors
/// A sentence, if it cannot run.
pub fn measure(benchmark: &Benchmark, plan: &BenchmarkPlan) -> Result<Vec<BenchmarkRow>, String> {
    let limited = benchmark.quantities.iter().any(|quantity| quantity.traffic.is_some());
    let mut stream = limited.then(|| Stream::new(benchmark.threads)).transpose()?;
    let mut measure = (benchmark.make)()?;
    // The first pass is not counted: it touches memory that lay idle.
    if let Some(stream) = &mut stream {
        stream.in_place();
    }
    let mut found = vec![Vec::new(); benchmark.quantities.len()];
    let mut shares = vec![Vec::new(); benchmark.quantities.len()];
    for _ in 0..plan.repeats.max(1) {
        let bandwidth = stream.as_mut().map(Stream::in_place);
        for (k, value) in measure(plan.seconds)?.into_iter().enumerate() {
            found[k].push(value);
            if let (Some(traffic), Some(bandwidth)) = (benchmark.quantities[k].traffic, bandwidth) {
                // Millions of updates a second times bytes each, over GB/s.
                shares[k].push(1e-3 * value * traffic / bandwidth);
            }
        }
    }
    let row = |(k, quantity): (usize, &Quantity)| {
        let values = sorted(&found[k]);
        Some(BenchmarkRow {
            case: benchmark.name.clone(),
            threads: benchmark.threads,
            quantity: quantity.clone(),
            median: *values.get(values.len() / 2)?,
            range: [*values.first()?, *values.last()?],
            share: sorted(&shares[k]).get(shares[k].len() / 2).copied(),
        })
    };
    Ok(benchmark.quantities.iter().enumerate().filter_map(row).collect())
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_sdk::benchmark::Measurement;

    fn plan(words: &[&str]) -> BenchmarkPlan {
        let words = words.iter().map(|word| word.to_string()).collect();
        let sizes = BenchmarkSizes { threads: vec![1], edge: 8 };
        BenchmarkPlan { words, sizes, repeats: 3, seconds: 1e-3 }
    }

    #[test]
    fn the_median_is_told_with_its_range() {
        let make = || {
            let mut values = [3.0, 1.0, 2.0].into_iter();
            let measure: Measurement = Box::new(move |_| Ok(values.next().into_iter().collect()));
            Ok(measure)
        };
        let quantities = vec![Quantity::new("", "1")];
        let case = Benchmark { name: "three".into(), threads: 1, quantities, make: Box::new(make) };
        let rows = measure(&case, &plan(&[])).unwrap();
        assert_eq!((rows[0].median, rows[0].range, rows[0].share), (2.0, [1.0, 3.0], None));
    }

    #[test]
    fn words_choose_cases() {
        let names = |words: &[&str]| -> Vec<String> {
            benchmarks(&plan(words)).into_iter().map(|case| case.name).collect()
        };
        assert!(names(&[]).len() > 10);
        let lattices = names(&["lattice", "f32"]);
        assert!(!lattices.is_empty() && lattices.iter().all(|name| name.contains("f32")));
        assert!(names(&["no such case"]).is_empty());
    }

    /// Small forms of all cases that need no processes give numbers.
    #[test]
    fn solvers_are_measured() {
        let plan = plan(&[]);
        for case in benchmarks(&plan).iter().filter(|case| case.threads > 0) {
            if case.name.contains("bed of") {
                continue;
            }
            for row in measure(case, &plan).unwrap() {
                assert!(
                    row.median.is_finite(),
                    "{} {}: {}",
                    row.case,
                    row.quantity.name,
                    row.median
                );
            }
        }
    }
}
