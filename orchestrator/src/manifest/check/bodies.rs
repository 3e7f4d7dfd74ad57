//! Checks of `[[scene.bodies]]`, set by set.

use super::super::document::{BodiesTable, PackingTable, SphereTable};
use super::super::path;
use super::super::read::Findings;
use std::collections::BTreeSet;
use tremie_messages::scene::{BodySet, Diameters, Packing, Placement, Sphere};

/// Spheres of one size fill no more than this of a space (Kepler); random ones far less.
const DENSEST: f64 = 0.7405;

/// The sets; `None` for each that is wrong.
pub(super) fn bodies(tables: &[BodiesTable], findings: &mut Findings) -> Vec<Option<BodySet>> {
    let mut names = BTreeSet::new();
    (tables.iter().enumerate())
        .map(|(i, table)| body_set(table, &path::item("scene.bodies", i), &mut names, findings))
        .collect()
}

fn body_set(
    table: &BodiesTable,
    at: &str,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<BodySet> {
    let name = findings.required(&table.name, at, "name");
    if let Some(name) = &name
        && !names.insert(name.clone())
    {
        findings.problem(
            &path::join(at, "name"),
            format!("a second set of bodies with the name \"{name}\""),
        );
    }
    let density = findings.positive(&table.density, at, "density");
    let placement = placement(table, at, findings);
    Some(BodySet {
        material: name.clone()?,
        name: name?,
        density: density?,
        motion: table.motion?.into(),
        placement: placement?,
    })
}

fn placement(table: &BodiesTable, at: &str, findings: &mut Findings) -> Option<Placement> {
    match (&table.spheres, &table.packing) {
        (Some(spheres), None) => {
            let at = path::join(at, "spheres");
            let spheres: Vec<_> = (spheres.iter().enumerate())
                .map(|(i, table)| sphere(table, &path::item(&at, i), findings))
                .collect();
            spheres.into_iter().collect::<Option<_>>().map(Placement::Listed)
        }
        (None, Some(table)) => {
            packing(table, &path::join(at, "packing"), findings).map(Placement::Packed)
        }
        (Some(_), Some(_)) => {
            findings.problem(
                &path::join(at, "packing"),
                "found both spheres and a packing, expected one of them",
            );
            None
        }
        (None, None) => {
            let keys = ["spheres", "packing"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                findings
                    .problem(at, "missing: where the bodies are, as \"spheres\" or as \"packing\"");
            }
            None
        }
    }
}

fn sphere(table: &SphereTable, at: &str, findings: &mut Findings) -> Option<Sphere> {
    let position = findings.required(&table.position, at, "position");
    let diameter = findings.positive(&table.diameter, at, "diameter");
    Some(Sphere {
        position: position?.map(|x| x.0),
        diameter: diameter?,
        velocity: table.velocity?.map(|v| v.0),
        angular_velocity: table.angular_velocity?.map(|w| w.0),
    })
}

fn packing(table: &PackingTable, at: &str, findings: &mut Findings) -> Option<Packing> {
    let min = findings.required(&table.min, at, "min");
    let max = findings.required(&table.max, at, "max");
    let fraction = findings.positive(&table.fraction, at, "fraction");
    if let Some(fraction) = fraction.filter(|fraction| *fraction > DENSEST) {
        let message =
            format!("found {fraction}, expected at most {DENSEST}, the densest packing of spheres");
        findings.problem(&path::join(at, "fraction"), message);
    }
    let diameters = diameters(table, at, findings);
    let (min, max) = (min?.map(|x| x.0), max?.map(|x| x.0));
    let diameters = diameters?;
    let [_, largest] = diameters.extremes();
    region_holds(&min, &max, largest, at, findings);
    // Without a seed of its own, a packing takes the run's, which may be the one that is wrong.
    Some(Packing { min, max, fraction: fraction?, diameters, seed: table.seed? })
}

/// Notes a region that is empty, or too narrow for one sphere.
fn region_holds(min: &[f64; 3], max: &[f64; 3], diameter: f64, at: &str, findings: &mut Findings) {
    let narrowest = (0..3).map(|a| max[a] - min[a]).fold(f64::INFINITY, f64::min);
    let key = path::join(at, "max");
    if narrowest <= 0.0 {
        findings.problem(
            &key,
            format!(
                "found {max:?} m, expected more than the lower corner {min:?} m along each axis"
            ),
        );
    } else if narrowest < diameter * (1.0 - 1e-9) {
        let message =
            format!("the region is {narrowest} m wide, too narrow for spheres of {diameter} m");
        findings.problem(&key, message);
    }
}

fn diameters(table: &PackingTable, at: &str, findings: &mut Findings) -> Option<Diameters> {
    match (&table.diameter, &table.diameters) {
        (Some(entry), None) => {
            let key = path::join(at, "diameter");
            let [min, max] = entry.bounds();
            if !findings.above_zero(min, &key) {
                return None;
            }
            if max < min {
                findings
                    .problem(&key, format!("found {min} to {max}, expected the smaller one first"));
                return None;
            }
            Some(Diameters::Uniform { min: min.0, max: max.0 })
        }
        (None, Some(list)) => {
            let key = path::join(at, "diameters");
            let wrong = list.iter().enumerate().find(|(_, d)| d.0 <= 0.0);
            if let Some((i, diameter)) = wrong {
                findings.above_zero(*diameter, &path::item(&key, i));
                return None;
            }
            if list.is_empty() {
                findings.problem(&key, "found an empty list, expected a diameter");
                return None;
            }
            Some(Diameters::Listed(list.iter().map(|d| d.0).collect()))
        }
        (Some(_), Some(_)) => {
            findings.problem(
                &path::join(at, "diameters"),
                "found both diameter and diameters, expected one of them",
            );
            None
        }
        (None, None) => {
            if !findings.is_unreadable(&path::join(at, "diameters")) {
                findings.missing(at, "diameter");
            }
            None
        }
    }
}
