//! Checks of a distribution of diameters.

use crate::checks::numbers::not_positive;
use crate::math::numbers::is_positive;
use crate::packing::random_packing::{LEAST_PART, Sizes};
use tremie_messages::{
    Problem,
    scene::{Diameters, SievePoint},
};

/// The largest diameter [m], if all is valid.
pub fn diameters(key: &str, diameters: &Diameters, problems: &mut Vec<Problem>) -> Option<f64> {
    let before = problems.len();
    let largest = match diameters {
        Diameters::Uniform { min, max } => {
            bounds(&format!("{key}.uniform"), *min, *max, problems);
            *max
        }
        Diameters::Normal { mean, deviation, min, max } => {
            let key = format!("{key}.normal");
            bounds(&key, *min, *max, problems);
            positive(&key, "mean", *mean, problems);
            positive(&key, "deviation", *deviation, problems);
            *max
        }
        Diameters::LogNormal { median, spread, min, max } => {
            let key = format!("{key}.lognormal");
            bounds(&key, *min, *max, problems);
            positive(&key, "median", *median, problems);
            if !(*spread > 1.0 && spread.is_finite()) {
                let message = format!("is {spread}, expected a factor of more than 1");
                problems.push(Problem::new(format!("{key}.spread"), message));
            }
            *max
        }
        Diameters::Sieve(points) => {
            sieve(&format!("{key}.sieve"), points, problems);
            points.last().map_or(0.0, |last| last.size)
        }
        Diameters::Listed(list) => {
            if list.is_empty() {
                problems.push(Problem::new(format!("{key}.listed"), "is empty"));
            }
            for (i, &d) in list.iter().enumerate() {
                if !is_positive(d) {
                    problems.push(not_positive(format!("{key}.listed[{i}]"), d));
                }
            }
            list.iter().fold(0.0, |a: f64, &b| a.max(b))
        }
    };
    if problems.len() > before {
        return None;
    }
    let part = Sizes::new(diameters).part_between_bounds();
    if part < LEAST_PART || part.is_nan() {
        let message = format!("has only {part:.1e} of the distribution between its bounds");
        let help = "move the bounds to where the distribution is";
        problems.push(Problem::new(key, message).help(help));
        return None;
    }
    Some(largest)
}

fn positive(key: &str, name: &str, value: f64, problems: &mut Vec<Problem>) {
    if !is_positive(value) {
        problems.push(not_positive(format!("{key}.{name}"), value));
    }
}

fn bounds(key: &str, min: f64, max: f64, problems: &mut Vec<Problem>) {
    positive(key, "min", min, problems);
    if !(max >= min && max.is_finite()) {
        let message = format!("is {max} m, less than the smallest, {min} m");
        problems.push(Problem::new(format!("{key}.max"), message));
    }
}

fn sieve(key: &str, points: &[SievePoint], problems: &mut Vec<Problem>) {
    for (i, point) in points.iter().enumerate() {
        if !is_positive(point.size) {
            problems.push(not_positive(format!("{key}[{i}].size"), point.size));
        }
        if !(0.0..=1.0).contains(&point.passing) {
            let message = format!("is {}, expected a part of the mass in [0, 1]", point.passing);
            problems.push(Problem::new(format!("{key}[{i}].passing"), message));
        }
    }
    for (i, pair) in points.windows(2).enumerate() {
        let next = i + 1;
        if pair[1].size <= pair[0].size {
            let message = format!("is not larger than that before, {} m", pair[0].size);
            problems.push(Problem::new(format!("{key}[{next}].size"), message));
        }
        if pair[1].passing < pair[0].passing {
            let message = format!("is less than that before, {}", pair[0].passing);
            problems.push(Problem::new(format!("{key}[{next}].passing"), message));
        }
    }
    let ends = points.first().zip(points.last());
    if points.len() < 2 || ends.is_some_and(|(a, b)| a.passing != 0.0 || b.passing != 1.0) {
        let message = "does not run from a size that passes 0 to one that passes 1";
        let help = "begin with the size of the smallest grain, and end with that of the largest";
        problems.push(Problem::new(key, message).help(help));
    }
}
