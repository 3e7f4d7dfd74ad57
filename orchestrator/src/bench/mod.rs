//! How fast Tremie is on this machine: `tremie bench`.
//!
//! Shared machines drift, so that seconds of one moment say little of another. Each case is measured several times, and
//! before each time the memory's bandwidth is, with as many threads; what is told is the median, how far it spread,
//! and which share of that bandwidth a kernel took. [`memory`] measures the bandwidth, [`lattice`] and
//! [`grains`] the solvers by themselves, [`coupled`] whole runs by this very program, and [`idle`] are components that
//! compute nothing.

pub mod coupled;
pub mod grains;
pub mod idle;
pub mod lattice;
pub mod memory;

use memory::Stream;
use serde::Serialize;

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// Words that the names of cases must have.
    pub words: Vec<String>,
    /// Numbers of threads.
    pub threads: Vec<usize>,
    /// Cells along an edge of the lattices.
    pub edge: usize,
    /// Measurements of each case.
    pub repeats: usize,
    /// How long a measurement takes, about [s].
    pub seconds: f64,
}

/// Something that can be measured.
pub struct Case {
    /// What it is, in words.
    pub name: String,
    /// Threads, of this process; 0 where that has no meaning.
    pub threads: usize,
    /// What it gives.
    pub quantities: Vec<Quantity>,
    /// Makes it ready, and gives what measures it.
    pub make: Box<dyn Fn() -> Result<Measure, String>>,
}

/// Measures once, for about so many seconds: a value of each quantity.
pub type Measure = Box<dyn FnMut(f64) -> Result<Vec<f64>, String>>;

/// A number that a case gives.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// What it is; empty where the case has no other.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Bytes that must at least be read and written for a million of it, if it is a rate that memory limits [MB].
    pub traffic: Option<f64>,
}

impl Quantity {
    /// Of a name and a unit.
    pub fn new(name: &str, unit: &'static str) -> Self {
        Self { name: name.into(), unit, traffic: None }
    }
}

/// What was found of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
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

/// All cases, in order.
pub fn cases(asked: &Asked) -> Vec<Case> {
    let mut cases = memory::cases(asked);
    cases.extend(lattice::cases(asked));
    cases.extend(grains::cases(asked));
    cases.extend(coupled::cases());
    let wanted = |case: &Case| {
        let threads = match case.threads {
            0 => String::new(),
            1 => "1 thread".into(),
            threads => format!("{threads} threads"),
        };
        asked.words.iter().all(|word| case.name.contains(word) || threads.contains(word))
    };
    cases.retain(wanted);
    cases
}

/// Measures a case.
///
/// # Errors
/// What keeps it from running.
pub fn measure(case: &Case, asked: &Asked) -> Result<Vec<Row>, String> {
    let limited = case.quantities.iter().any(|quantity| quantity.traffic.is_some());
    let mut stream = limited.then(|| Stream::new(case.threads)).transpose()?;
    let mut measure = (case.make)()?;
    // Memory that lay idle may have to be found again.
    if let Some(stream) = &mut stream {
        stream.in_place();
    }
    let mut found = vec![Vec::new(); case.quantities.len()];
    let mut shares = vec![Vec::new(); case.quantities.len()];
    for _ in 0..asked.repeats.max(1) {
        let bandwidth = stream.as_mut().map(Stream::in_place);
        for (k, value) in measure(asked.seconds)?.into_iter().enumerate() {
            found[k].push(value);
            if let (Some(traffic), Some(bandwidth)) = (case.quantities[k].traffic, bandwidth) {
                shares[k].push(1e-3 * value * traffic / bandwidth);
            }
        }
    }
    let row = |(k, quantity): (usize, &Quantity)| {
        let values = sorted(&found[k]);
        Some(Row {
            case: case.name.clone(),
            threads: case.threads,
            quantity: quantity.clone(),
            median: *values.get(values.len() / 2)?,
            range: [*values.first()?, *values.last()?],
            share: sorted(&shares[k]).get(shares[k].len() / 2).copied(),
        })
    };
    Ok(case.quantities.iter().enumerate().filter_map(row).collect())
}

fn sorted(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(words: &[&str]) -> Asked {
        let words = words.iter().map(|word| word.to_string()).collect();
        Asked { words, threads: vec![1], edge: 8, repeats: 3, seconds: 1e-3 }
    }

    #[test]
    fn the_median_is_told_with_its_range() {
        let make = || {
            let mut values = [3.0, 1.0, 2.0].into_iter();
            let measure: Measure = Box::new(move |_| Ok(values.next().into_iter().collect()));
            Ok(measure)
        };
        let quantities = vec![Quantity::new("", "1")];
        let case = Case { name: "three".into(), threads: 1, quantities, make: Box::new(make) };
        let rows = measure(&case, &asked(&[])).unwrap();
        assert_eq!((rows[0].median, rows[0].range, rows[0].share), (2.0, [1.0, 3.0], None));
    }

    #[test]
    fn words_choose_cases() {
        let names = |words: &[&str]| -> Vec<String> {
            cases(&asked(words)).into_iter().map(|case| case.name).collect()
        };
        assert!(names(&[]).len() > 10);
        let lattices = names(&["lattice", "f32"]);
        assert!(!lattices.is_empty() && lattices.iter().all(|name| name.contains("f32")));
        assert!(names(&["no such case"]).is_empty());
    }

    /// Small forms of all cases that need no processes give numbers.
    #[test]
    fn solvers_are_measured() {
        let asked = asked(&[]);
        for case in cases(&asked).iter().filter(|case| case.threads > 0) {
            if case.name.contains("32,000") {
                continue;
            }
            for row in measure(case, &asked).unwrap() {
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
