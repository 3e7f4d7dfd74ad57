//! Series: runs that differ in one quantity.

use super::valve_run::{ValveRun, Varied};
use crate::scene::Closure;

/// The longest series of runs of a valve that differ in one quantity, in its order. Runs with the
/// same number, with other seeds, stand together.
#[derive(Clone, Debug, Default)]
pub struct Series<'r, 'a> {
    /// The number, and the runs that have it.
    pub points: Vec<(f64, Vec<&'r ValveRun<'a>>)>,
}

impl<'r, 'a> Series<'r, 'a> {
    /// Of the runs of a kind, with grains or without.
    pub fn longest(runs: &'r [ValveRun<'a>], kind: Closure, grains: bool, varied: Varied) -> Self {
        let fits = |run: &&ValveRun| run.kind == kind && run.diameters.is_some() == grains;
        let of = |first: &'r ValveRun<'a>| {
            let like = runs.iter().filter(|run| run.differs_only_in(first, varied));
            Self::ordered(like, varied)
        };
        let all = runs.iter().filter(fits).map(of);
        // The first of several that are equally long.
        all.reduce(|best, next| if next.points.len() > best.points.len() { next } else { best })
            .unwrap_or_default()
    }

    fn ordered(runs: impl Iterator<Item = &'r ValveRun<'a>>, varied: Varied) -> Self {
        let mut runs: Vec<_> = runs.collect();
        runs.sort_by(|a, b| a.number(varied).total_cmp(&b.number(varied)));
        let mut points: Vec<(f64, Vec<_>)> = Vec::new();
        for run in runs {
            let number = run.number(varied);
            match points.last_mut() {
                Some((last, same)) if number - *last <= 1e-6 * number.abs() => same.push(run),
                _ => points.push((number, vec![run])),
            }
        }
        Self { points }
    }

    /// A number of each point, the mean over its runs; points without any are left out.
    pub fn values(&self, of: impl Fn(&ValveRun<'a>) -> Option<f64>) -> Vec<[f64; 2]> {
        let mean = |runs: &[&ValveRun<'a>]| {
            let found: Vec<f64> = runs.iter().filter_map(|run| of(run)).collect();
            (!found.is_empty()).then(|| found.iter().sum::<f64>() / found.len() as f64)
        };
        let points = self.points.iter();
        points.filter_map(|(number, runs)| Some([*number, mean(runs)?])).collect()
    }
}

/// True if values grow along a series, each by no less than -1 % of the one before, the last over
/// the first by more than a twentieth.
pub fn grows(values: &[[f64; 2]]) -> bool {
    let each = values.windows(2).all(|pair| pair[1][1] >= 0.99 * pair[0][1]);
    each && values.first().zip(values.last()).is_some_and(|(a, b)| b[1] > 1.05 * a[1])
}

/// True if values fall along a series.
pub fn falls(values: &[[f64; 2]]) -> bool {
    grows(&values.iter().rev().copied().collect::<Vec<_>>())
}

/// Greatest over least value, less 1.
pub fn scatter(values: &[[f64; 2]]) -> f64 {
    let of = |start: f64, pick: fn(f64, f64) -> f64| values.iter().map(|v| v[1]).fold(start, pick);
    of(-f64::INFINITY, f64::max) / of(f64::INFINITY, f64::min) - 1.0
}
