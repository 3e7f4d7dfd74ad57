//! Checks of `[[scene.gaps]]`.

use super::super::document::{GapPressureName, GapTable, RingTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::probes;
use std::collections::BTreeSet;
use tremie_messages::scene::{Domain, Gap, GapRegion, GapRule, GapSide, GapWeight, ProbeShape};

/// Thicknesses at which gaps open and close, if nothing is said [cells].
const OPEN_AT: f64 = 1.5;
const CLOSE_AT: f64 = 0.5;

pub(super) fn gaps(
    table: &SceneTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> Option<Vec<Gap>> {
    let mut names = BTreeSet::new();
    let gaps: Vec<_> = (table.gaps.iter().enumerate())
        .map(|(i, gap)| {
            let at = path::item("scene.gaps", i);
            let name = probes::name(&gap.name, &at, &mut names, findings);
            let between = between(gap, table, &at, findings);
            let thickness = thickness(gap, &at, findings);
            let pressure = pressure(gap, table, &at, findings);
            let region = region(gap, domain?, &at, findings);
            let [open_at, close_at, slip_below] = thickness?;
            Some(Gap {
                name: name?,
                between: between?,
                open_at,
                close_at,
                pressure: pressure?,
                slip_below,
                region: region?,
            })
        })
        .collect();
    gaps.into_iter().collect()
}

fn between(
    gap: &GapTable,
    table: &SceneTable,
    at: &str,
    findings: &mut Findings,
) -> Option<[GapSide; 2]> {
    let [one, other] = findings.required(&gap.between, at, "between")?;
    let key = path::join(at, "between");
    if one == other {
        findings.problem(&key, format!("found \"{one}\" twice, expected two surfaces"));
        return None;
    }
    let one = side(&one, table, &path::item(&key, 0), findings);
    let other = side(&other, table, &path::item(&key, 1), findings);
    Some([one?, other?])
}

/// A part, a surface, or a face of the domain.
fn side(name: &str, table: &SceneTable, key: &str, findings: &mut Findings) -> Option<GapSide> {
    let is_part = table.parts.iter().any(|part| part.name.as_deref() == Some(name));
    if is_part || table.surfaces.iter().any(|surface| surface.name.as_deref() == Some(name)) {
        return Some(GapSide::Part(name.into()));
    }
    for (axis, letter) in ["x", "y", "z"].into_iter().enumerate() {
        for (side, word) in ["lower", "upper"].into_iter().enumerate() {
            if name == format!("{word} {letter}") {
                return Some(GapSide::Face { axis, side });
            }
        }
    }
    let message = format!(
        "found \"{name}\", expected the name of a part or surface, or a face as \"lower x\""
    );
    findings.problem(key, message);
    None
}

/// `open_at`, `close_at` and `slip_below`.
fn thickness(gap: &GapTable, at: &str, findings: &mut Findings) -> Option<[f64; 3]> {
    let open_at = gap.open_at.unwrap_or(OPEN_AT);
    let close_at = gap.close_at.unwrap_or(CLOSE_AT.min(open_at));
    let slip_below = gap.slip_below.unwrap_or(0.0);
    let mut right = true;
    let mut problem = |key: &str, message: String| {
        findings.problem(&path::join(at, key), message);
        right = false;
    };
    if !(open_at.is_finite() && open_at > 0.0) {
        problem("open_at", format!("found {open_at} cells, expected more than 0"));
    }
    if !(0.0..=open_at).contains(&close_at) {
        problem("close_at", format!("found {close_at} cells, expected from 0 to `open_at`"));
    }
    if !(slip_below.is_finite() && slip_below >= 0.0) {
        problem("slip_below", format!("found {slip_below} cells, expected 0 or more"));
    }
    right.then_some([open_at, close_at, slip_below])
}

fn pressure(
    gap: &GapTable,
    table: &SceneTable,
    at: &str,
    findings: &mut Findings,
) -> Option<GapRule> {
    let Some(names) = &gap.pressure_at else {
        if gap.weights.is_some() {
            let message = "there is no `pressure_at`: weights are those of its probes";
            findings.problem(&path::join(at, "weights"), message);
            return None;
        }
        return Some(match gap.pressure {
            Some(GapPressureName::Zero) => GapRule::Zero,
            Some(GapPressureName::Nearest) | None => GapRule::Nearest,
        });
    };
    let key = path::join(at, "pressure_at");
    if gap.pressure.is_some() {
        findings.problem(&key, "is given together with `pressure`: leave one out");
        return None;
    }
    for (i, name) in names.iter().enumerate() {
        if !table.probes.iter().any(|probe| probe.name.as_ref() == Some(name)) {
            let message = format!("found \"{name}\", expected the name of a probe");
            findings.problem(&path::item(&key, i), message);
            return None;
        }
    }
    let weights = gap.weights.clone().unwrap_or_else(|| vec![1.0; names.len()]);
    let fit = weights.len() == names.len() && weights.iter().all(|w| w.is_finite() && *w >= 0.0);
    if !fit || weights.iter().sum::<f64>() <= 0.0 {
        let message = format!(
            "found {weights:?}, expected a weight for each of the {} probes, none negative, not all 0",
            names.len()
        );
        let key = if gap.weights.is_some() { path::join(at, "weights") } else { key };
        findings.problem(&key, message);
        return None;
    }
    let weighted = names.iter().zip(weights);
    let weighted = weighted.map(|(probe, weight)| GapWeight { probe: probe.clone(), weight });
    Some(GapRule::Probes(weighted.collect()))
}

/// Region of the gap; `None` only if that is wrong.
fn region(
    gap: &GapTable,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> Option<Option<GapRegion>> {
    match (&gap.region, &gap.ring) {
        (None, None) => Some(None),
        (Some(_), Some(_)) => {
            let message = "is given together with `region`: leave one out";
            findings.problem(&path::join(at, "ring"), message);
            None
        }
        (Some(table), None) => {
            match probes::region(table, &path::join(at, "region"), domain, findings)? {
                ProbeShape::Region { min, max } => Some(Some(GapRegion::Box { min, max })),
                _ => None,
            }
        }
        (None, Some(table)) => ring(table, &path::join(at, "ring"), findings).map(Some),
    }
}

fn ring(table: &RingTable, at: &str, findings: &mut Findings) -> Option<GapRegion> {
    let axis = findings.required(&table.axis, at, "axis");
    let through = findings.required(&table.through, at, "through");
    let radii = findings.required(&table.radii, at, "radii")?.map(|radius| radius.0);
    if !(0.0 <= radii[0] && radii[0] < radii[1]) {
        let message = format!("found {radii:?} m, expected the inner radius, then a larger one");
        findings.problem(&path::join(at, "radii"), message);
        return None;
    }
    let axis = axis?.number();
    Some(GapRegion::Ring { axis, through: through?.map(|x| x.0), radii })
}
