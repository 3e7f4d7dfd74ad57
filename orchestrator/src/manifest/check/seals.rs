//! Checks of `[[scene.surfaces]]`, with the tables that they name.

use super::super::document::{PartTable, SurfaceTable};
use super::super::path;
use super::super::read::Findings;
use super::parts::{name, orientation};
use crate::registry::SealTable;
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::Path;
use tremie_messages::finding::short;
use tremie_messages::scene::{DeformableSurface, Domain, FacetKind, Pose, Section, SurfaceStart};
use tremie_sdk::parameters::nearest;

/// Fewest steps that make a solid of a section.
const FEWEST_SECTORS: u32 = 3;
/// Most steps: beyond, a mistake is more likely than a wish.
const MOST_SECTORS: u32 = 10_000;
/// Stiffness of a seat that is given none, over that of the seal at rest: the seal, not the seat,
/// gives way.
const SEAT_OVER_SEAL: f64 = 100.0;

pub(super) fn surfaces(
    tables: &[SurfaceTable],
    parts: &[PartTable],
    findings: &mut Findings,
) -> Option<Vec<DeformableSurface>> {
    let mut names: BTreeSet<String> = parts.iter().filter_map(|part| part.name.clone()).collect();
    let all: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| {
            surface(table, parts, &path::item("scene.surfaces", i), &mut names, findings)
        })
        .collect();
    all.into_iter().collect()
}

fn surface(
    table: &SurfaceTable,
    parts: &[PartTable],
    at: &str,
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<DeformableSurface> {
    let name = name(&table.name, "part or surface", at, names, findings);
    let carrier = carrier(table, parts, at, findings);
    let orientation = match &table.rotation {
        Some(rotation) => orientation(rotation, &path::join(at, "rotation"), findings),
        None => Some(Pose::IDENTITY.orientation),
    };
    let sectors = sectors(table, at, findings);
    let stiffness = table
        .seat_stiffness
        .map(|stiffness| findings.above_zero(stiffness, &path::join(at, "seat_stiffness")));
    let shapes = shapes(table, at, findings)?;
    let section = shapes.outline().section;
    let foot = foot_area(&section);
    let given = table.seat_stiffness.map(|stiffness| stiffness.0);
    let whole = given.unwrap_or(SEAT_OVER_SEAL * shapes.slope(shapes.bracket(0.0).ok()?));
    if stiffness == Some(false) {
        return None;
    }
    Some(DeformableSurface {
        name: name?,
        carrier: carrier?,
        table: table.table.clone()?,
        pose: Pose { position: table.position?.map(|x| x.0), orientation: orientation? },
        sectors: sectors?,
        material: table.material.clone().unwrap_or_else(|| Domain::MATERIAL.into()),
        seat_stiffness: whole / foot,
        start: start(&shapes, table.start?.0),
        section,
    })
}

/// The shape at a compression that the table has.
fn start(shapes: &SealTable, compression: f64) -> SurfaceStart {
    match shapes.bracket(compression) {
        Ok(at) if compression > 0.0 => {
            let section = shapes.vertices(at);
            let points = shapes.outline().vertices.into_iter().map(|vertex| section[vertex]);
            SurfaceStart { compression, points: points.collect() }
        }
        _ => SurfaceStart::default(),
    }
}

fn carrier(
    table: &SurfaceTable,
    parts: &[PartTable],
    at: &str,
    findings: &mut Findings,
) -> Option<String> {
    let carrier = findings.required(&table.carrier, at, "carrier")?;
    let names: Vec<&str> = parts.iter().filter_map(|part| part.name.as_deref()).collect();
    if names.contains(&carrier.as_str()) || findings.is_unreadable("scene.parts") {
        return Some(carrier);
    }
    let help = match nearest(&carrier, &names) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None if names.is_empty() => {
            "add [[scene.parts]] with what the surface is bonded to".to_string()
        }
        None => format!("parts: {}", names.join(", ")),
    };
    let message = format!("there is no part \"{carrier}\" that could carry the surface");
    findings.problem_with_help(&path::join(at, "carrier"), message, help);
    None
}

fn sectors(table: &SurfaceTable, at: &str, findings: &mut Findings) -> Option<u32> {
    let sectors = table.sectors?;
    if (FEWEST_SECTORS..=MOST_SECTORS).contains(&sectors) {
        return Some(sectors);
    }
    let message = format!("found {sectors}, expected {FEWEST_SECTORS} to {MOST_SECTORS}");
    findings.problem(&path::join(at, "sectors"), message);
    None
}

/// The table, if it can be read and is one for a run.
fn shapes(table: &SurfaceTable, at: &str, findings: &mut Findings) -> Option<SealTable> {
    let file = findings.required(&table.table, at, "table")?;
    let key = path::join(at, "table");
    let shapes = match SealTable::read(Path::new(&file)) {
        Ok(shapes) => shapes,
        Err(error) => {
            let help = "`tremie rubber make-table` writes tables; a relative path begins at the manifest's folder";
            findings.problem_with_help(&key, error.to_string(), help);
            return None;
        }
    };
    if shapes.contents().facets.exposed.is_empty() {
        let message = format!(
            "{file}: no facets are \"exposed\"; the pressure around a seal is that on them, and what presses its foot counts against it"
        );
        findings.problem(&key, message);
        return None;
    }
    let last = shapes.last_compression();
    for (key, wanted) in [("compression", table.compression), ("start", table.start)] {
        let Some(wanted) = wanted.filter(|wanted| !(0.0..=last).contains(&wanted.0)) else {
            continue;
        };
        let found = format!("found {} m, ", short(wanted.0));
        let (message, help) = match wanted.0 > last {
            true => (
                format!("{found}but the table {file} ends at a compression of {} m", short(last)),
                "make a table with a larger compression",
            ),
            false => (format!("{found}expected zero or more"), "a seal is pressed, never drawn"),
        };
        findings.problem_with_help(&path::join(at, key), message, help);
        return None;
    }
    Some(shapes)
}

/// Area of what touches the seat, at rest: frustums of cones.
fn foot_area(section: &Section) -> f64 {
    let point = |index: u32| section.points[index as usize];
    let frustum = |[a, b]: [[f64; 2]; 2]| {
        let (across, along) = (b[0] - a[0], b[1] - a[1]);
        PI * (a[0] + b[0]) * (across * across + along * along).sqrt()
    };
    let foot = section.edges.iter().filter(|edge| edge.kind == FacetKind::Seat);
    foot.map(|edge| frustum(edge.points.map(point))).sum()
}
