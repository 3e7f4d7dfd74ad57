//! Checks of `[[scene.probes]]`.

use super::super::document::{ProbeRingTable, ProbeTable, ProfileTable, RegionTable, SectionTable};
use super::super::path;
use super::super::read::Findings;
use std::collections::BTreeSet;
use tremie_messages::scene::{Domain, Probe, ProbeShape, Ring};
use tremie_messages::units::Length;

pub(super) fn probes(
    tables: &[ProbeTable],
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vec<Probe>> {
    let mut names = BTreeSet::new();
    let probes: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| {
            let at = path::item("scene.probes", i);
            let name = name(&table.name, &at, &mut names, findings);
            let shape = shape(table, &at, domain?, findings);
            Some(Probe { name: name?, shape: shape? })
        })
        .collect();
    probes.into_iter().collect()
}

/// Names of probes become parts of the names of signals; those of gaps are made alike.
pub(super) fn name(
    name: &Option<String>,
    at: &str,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<String> {
    let taken = |name: &str| format!("a second probe or gap with the name \"{name}\"");
    findings.name(name, at, &[], names, taken)
}

fn shape(
    table: &ProbeTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<ProbeShape> {
    let kinds = [
        ("point", table.point.is_some()),
        ("line", table.line.is_some()),
        ("section", table.section.is_some()),
        ("profile", table.profile.is_some()),
        ("region", table.region.is_some()),
        ("ring", table.ring.is_some()),
    ];
    let kind = findings.only_one(&kinds, "where the probe is", at)?;
    let key = path::join(at, kind);
    match kind {
        "point" => {
            let point = table.point?.map(|x| x.0);
            inside(&point, domain, &key, findings).then_some(ProbeShape::Point(point))
        }
        "line" => {
            let line = table.line.as_ref()?;
            let mut end = |value: &Option<[Length; 3]>, name: &str| {
                let point = findings.required(value, &key, name)?.map(|x| x.0);
                inside(&point, domain, &path::join(&key, name), findings).then_some(point)
            };
            let (from, to) = (end(&line.from, "from"), end(&line.to, "to"));
            Some(ProbeShape::Line { from: from?, to: to? })
        }
        "section" => section(table.section.as_ref()?, &key, domain, findings),
        "profile" => profile(table.profile.as_ref()?, &key, domain, findings),
        "ring" => ring(table.ring.as_ref()?, &key, domain, findings),
        _ => region(table.region.as_ref()?, &key, domain, findings),
    }
}

fn section(
    table: &SectionTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<ProbeShape> {
    let axis = findings.required(&table.axis, at, "axis");
    let position = findings.required(&table.at, at, "at");
    let axis = axis?.number();
    let position = position?.0;
    if position < domain.min[axis] || position > domain.max[axis] {
        let message = format!(
            "found {position} m, outside the domain, which reaches from {} to {} m there",
            domain.min[axis], domain.max[axis]
        );
        findings.problem(&path::join(at, "at"), message);
        return None;
    }
    let min = table.min.map_or(domain.min, |min| min.map(|x| x.0));
    let max = table.max.map_or(domain.max, |max| max.map(|x| x.0));
    holds(&min, &max, Some(axis), domain, at, findings).then_some(ProbeShape::Section {
        axis,
        position,
        min,
        max,
    })
}

fn profile(
    table: &ProfileTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<ProbeShape> {
    let ProfileTable { axis, at: place, min, max, .. } = table.clone();
    let section = section(&SectionTable { axis, at: place, min, max }, at, domain, findings);
    let along = findings.required(&table.along, at, "along")?;
    let bins = table.bins.unwrap_or(16) as usize;
    if !(1..=ProbeShape::MOST_BINS).contains(&bins) {
        let message = format!("found {bins}, expected 1 to {}", ProbeShape::MOST_BINS);
        findings.problem(&path::join(at, "bins"), message);
        return None;
    }
    if table.axis == Some(along) {
        let message = "found the section's own axis, expected one of the two across it";
        findings.problem(&path::join(at, "along"), message);
        return None;
    }
    let along = along.number();
    let ProbeShape::Section { axis, position, min, max } = section? else { return None };
    Some(ProbeShape::Profile { axis, position, min, max, along, bins })
}

fn ring(
    table: &ProbeRingTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<ProbeShape> {
    let axis = findings.required(&table.axis, at, "axis");
    let through = findings.required(&table.through, at, "through");
    let mut pair = |value: &Option<[Length; 2]>, name: &str, least: f64, words: &str| {
        let [from, to] = findings.required(value, at, name)?.map(|x| x.0);
        if least <= from && from < to {
            return Some([from, to]);
        }
        let message = format!("found {from} and {to} m, expected {words}");
        findings.problem(&path::join(at, name), message);
        None
    };
    let radii = pair(&table.radii, "radii", 0.0, "the inner radius, then a larger one");
    let heights = pair(&table.heights, "heights", f64::MIN, "the lower end, then a higher one");
    let axis = axis?.number();
    let ring = Ring { axis, through: through?.map(|x| x.0), radii: radii?, heights: heights? };
    let [min, max] = ring.corners();
    if (0..3).any(|a| max[a] <= domain.min[a] || min[a] >= domain.max[a]) {
        let message = format!("lies outside the domain, which is {}", super::extent(domain));
        findings.problem(at, message);
        return None;
    }
    Some(ProbeShape::Ring(ring))
}

pub(super) fn region(
    table: &RegionTable,
    at: &str,
    domain: &Domain,
    findings: &mut Findings,
) -> Option<ProbeShape> {
    let min = findings.required(&table.min, at, "min");
    let max = findings.required(&table.max, at, "max");
    let (min, max) = (min?.map(|x| x.0), max?.map(|x| x.0));
    holds(&min, &max, None, domain, at, findings).then_some(ProbeShape::Region { min, max })
}

/// True if a box has an extent along every axis but `across`, and lies in the domain there.
pub(super) fn holds(
    min: &[f64; 3],
    max: &[f64; 3],
    across: Option<usize>,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> bool {
    let axes = || (0..3).filter(|a| Some(*a) != across);
    if axes().any(|a| max[a] <= min[a]) {
        let message = format!(
            "found {max:?} m, expected more than the lower corner {min:?} m along each axis"
        );
        findings.problem(&path::join(at, "max"), message);
        return false;
    }
    let slack = domain.size().map(|size| 1e-9 * size);
    let out = |a: usize| min[a] < domain.min[a] - slack[a] || max[a] > domain.max[a] + slack[a];
    if axes().any(out) {
        let message = format!("reaches out of the domain, which is {}", super::extent(domain));
        findings.problem(at, message);
        return false;
    }
    true
}

pub(super) fn inside(
    point: &[f64; 3],
    domain: &Domain,
    key: &str,
    findings: &mut Findings,
) -> bool {
    let right = (0..3).all(|a| point[a] >= domain.min[a] && point[a] <= domain.max[a]);
    if !right {
        let message =
            format!("{point:?} m is not inside the domain, which is {}", super::extent(domain));
        findings.problem_with_help(key, message, super::BRING_INSIDE);
    }
    right
}
