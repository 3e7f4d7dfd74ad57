//! Checks of the diameters of a packing.

use super::super::document::{
    DiameterEntry, DiametersEntry, DistributionTable, LogNormalTable, NormalTable, PackingTable,
};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{Diameters, SievePoint};
use tremie_messages::units::Length;

pub(super) fn diameters(
    table: &PackingTable,
    at: &str,
    findings: &mut Findings,
) -> Option<Diameters> {
    let key = path::join(at, "diameters");
    match (&table.diameter, &table.diameters) {
        (Some(entry), None) => uniform(entry, &path::join(at, "diameter"), findings),
        (None, Some(DiametersEntry::List(list))) => listed(list, &key, findings),
        (None, Some(DiametersEntry::Distribution(table))) => distribution(table, &key, findings),
        (Some(_), Some(_)) => {
            findings.problem(&key, "found both diameter and diameters, expected one of them");
            None
        }
        (None, None) => {
            if !findings.is_unreadable(&key) {
                findings.missing(at, "diameter");
            }
            None
        }
    }
}

fn uniform(entry: &DiameterEntry, at: &str, findings: &mut Findings) -> Option<Diameters> {
    let [min, max] = entry.bounds();
    if !findings.above_zero(min, at) {
        return None;
    }
    if max < min {
        findings.problem(at, format!("found {min} to {max}, expected the smaller one first"));
        return None;
    }
    Some(Diameters::Uniform { min: min.0, max: max.0 })
}

fn listed(list: &[Length], at: &str, findings: &mut Findings) -> Option<Diameters> {
    if let Some((i, diameter)) = list.iter().enumerate().find(|(_, d)| d.0 <= 0.0) {
        findings.above_zero(*diameter, &path::item(at, i));
        return None;
    }
    if list.is_empty() {
        findings.problem(at, "found an empty list, expected a diameter");
        return None;
    }
    Some(Diameters::Listed(list.iter().map(|d| d.0).collect()))
}

fn distribution(table: &DistributionTable, at: &str, findings: &mut Findings) -> Option<Diameters> {
    let kinds = [
        ("normal", table.normal.is_some()),
        ("log_normal", table.log_normal.is_some()),
        ("sieve", table.sieve.is_some()),
    ];
    let kind = findings.only_one(&kinds, "a distribution", at)?;
    let at = path::join(at, kind);
    match (&table.normal, &table.log_normal, &table.sieve) {
        (Some(table), ..) => normal(table, &at, findings),
        (_, Some(table), _) => log_normal(table, &at, findings),
        (.., Some(points)) => sieve(points, &at, findings),
        _ => None,
    }
}

fn normal(table: &NormalTable, at: &str, findings: &mut Findings) -> Option<Diameters> {
    let mean = findings.positive(&table.mean, at, "mean");
    let deviation = findings.positive(&table.deviation, at, "deviation");
    let (min, max) = bounds(&table.min, &table.max, at, findings)?;
    let (mean, deviation) = (mean?, deviation?);
    // Farther out, the distribution has no numbers left to draw.
    let reach = [(min - mean) / deviation, (max - mean) / deviation];
    is_drawn(reach, "the mean", at, findings).then_some(Diameters::Normal {
        mean,
        deviation,
        min,
        max,
    })
}

fn log_normal(table: &LogNormalTable, at: &str, findings: &mut Findings) -> Option<Diameters> {
    let median = findings.positive(&table.median, at, "median");
    let spread = findings.required(&table.spread, at, "spread").filter(|spread| {
        let right = *spread > 1.0;
        if !right {
            let message = format!("found {spread}, expected a ratio of more than 1");
            findings.problem(&path::join(at, "spread"), message);
        }
        right
    });
    let (min, max) = bounds(&table.min, &table.max, at, findings)?;
    let (median, spread) = (median?, spread?);
    let reach = [(min / median).ln() / spread.ln(), (max / median).ln() / spread.ln()];
    is_drawn(reach, "the median", at, findings).then_some(Diameters::LogNormal {
        median,
        spread,
        min,
        max,
    })
}

/// Most standard deviations by which all of a cut distribution may lie off its centre.
const FARTHEST: f64 = 6.0;

/// True if anything of a distribution is left between bounds, in standard deviations from its
/// centre.
fn is_drawn([low, high]: [f64; 2], centre: &str, at: &str, findings: &mut Findings) -> bool {
    let right = low < FARTHEST && high > -FARTHEST;
    if !right {
        let message = format!(
            "all diameters from min to max lie more than {FARTHEST} standard deviations from {centre}: there are none"
        );
        findings.problem(at, message);
    }
    right
}

fn bounds(
    min: &Option<Length>,
    max: &Option<Length>,
    at: &str,
    findings: &mut Findings,
) -> Option<(f64, f64)> {
    let low = findings.positive(min, at, "min");
    let high = findings.positive(max, at, "max");
    let (low, high) = (low?, high?);
    if high <= low {
        let message = format!("found {high} m, expected more than min, {low} m");
        findings.problem(&path::join(at, "max"), message);
        return None;
    }
    Some((low, high))
}

fn sieve(points: &[(Length, f64)], at: &str, findings: &mut Findings) -> Option<Diameters> {
    if points.len() < 2 {
        let message = format!("found {} points, expected two or more", points.len());
        findings.problem(at, message);
        return None;
    }
    let mut right = true;
    for (i, (size, _)) in points.iter().enumerate() {
        let at = path::item(at, i);
        right &= findings.above_zero(*size, &at);
        if i > 0 && *size <= points[i - 1].0 {
            let message =
                format!("found {size} after {}, expected sizes that ascend", points[i - 1].0);
            findings.problem(&at, message);
            right = false;
        }
        if i > 0 && points[i].1 < points[i - 1].1 {
            let message = format!(
                "{} of the mass pass, less than the {} of the finer sieve",
                points[i].1,
                points[i - 1].1
            );
            findings.problem(&at, message);
            right = false;
        }
    }
    for (i, expected) in [(0, 0.0), (points.len() - 1, 1.0)] {
        if points[i].1 != expected {
            let message =
                format!("{} of the mass pass, expected {expected} at this end", points[i].1);
            findings.problem(&path::item(at, i), message);
            right = false;
        }
    }
    let points =
        points.iter().map(|(size, passing)| SievePoint { size: size.0, passing: *passing });
    right.then(|| Diameters::Sieve(points.collect()))
}
