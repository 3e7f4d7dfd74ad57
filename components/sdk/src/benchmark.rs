//! Benchmarks that a component brings along: `tremie bench` measures them in turn with the memory's
//! bandwidth.

use serde::Serialize;

/// Sizes of benchmarks, as the user wants them.
#[derive(Clone, Debug, PartialEq)]
pub struct BenchmarkSizes {
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Cells along an edge of a fluid's grid.
    pub edge: usize,
}

/// Something that can be measured.
pub struct Benchmark {
    /// Its name, in words.
    pub name: String,
    /// Threads, of this process; 0 where that has no meaning.
    pub threads: usize,
    /// Its results.
    pub quantities: Vec<Quantity>,
    /// Makes it ready, and gives what measures it.
    pub make: Box<dyn Fn() -> Result<Measurement, String>>,
}

/// Measures once, for about so many seconds: a value of each quantity.
pub type Measurement = Box<dyn FnMut(f64) -> Result<Vec<f64>, String>>;

/// A number that a benchmark gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// Its name; empty where the benchmark has no other.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Bytes that must at least be read and written for a million of it, if it is a rate that
    /// memory limits [MB].
    pub traffic: Option<f64>,
}

impl Quantity {
    /// Of a name and a unit.
    pub fn new(name: &str, unit: &'static str) -> Self {
        Self { name: name.into(), unit, traffic: None }
    }
}
