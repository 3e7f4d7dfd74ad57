//! Checks of `[scene]`: what belongs to no list of its own, and how the lists go together.

use super::super::document::{PlaneTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::contacts::{Surroundings, contacts};
use super::polyhedra::Shapes;
use super::{
    bodies, domain, drag_bands, fluid, gaps, hoppers, inlets, materials, parts, placement, plane,
    probes, profiles, seals, surfaces,
};
use tremie_messages::scene::{BodySet, Domain, Part, Plane, Scene};

pub(super) fn scene(table: &SceneTable, findings: &mut Findings) -> Option<Scene> {
    let domain = domain::domain(&table.domain, findings);
    let fluid = fluid::fluid(table, domain.as_ref(), findings);
    materials::materials(table, findings);
    let planes = planes(&table.planes, findings);
    let mut parts = parts::parts(&table.parts, findings);
    let seals = seals::surfaces(&table.surfaces, &table.parts, findings);
    let shapes = Shapes::of(table, domain.as_ref(), findings);
    let mut bodies = bodies::bodies(&table.bodies, &shapes, findings);
    let mut names = inlets::Names::of(table);
    let unions = bodies::unions(&table.bodies, findings);
    let (inlets, own_sets) = inlets::inlets(table, &mut names, findings);
    bodies.extend(own_sets);
    let (walls, on_walls) = hoppers::hoppers(table, domain.as_ref(), findings);
    parts.extend(walls);
    bodies.extend(on_walls);
    let outlets = inlets::outlets(&table.outlets, domain.as_ref(), &mut names, findings);
    let drag_bands = drag_bands::drag_bands(table, domain.as_ref(), &mut names, findings);
    let probes = probes::probes(&table.probes, domain.as_ref(), findings);
    let profiles = profiles::profiles(table, domain.as_ref(), findings);
    let gaps = gaps::gaps(table, domain.as_ref(), findings);
    if let Some(domain) = &domain {
        plane::check(table, domain, &mut bodies, findings);
        placement::check(domain, planes.as_deref().unwrap_or(&[]), &bodies, findings);
        surfaces::check(domain, &parts, findings);
    }
    let parts: Option<Vec<Part>> = parts.into_iter().collect();
    let bodies: Option<Vec<BodySet>> = bodies.into_iter().collect();
    // Pairs that lack a law can be told only where everything that may touch is right.
    let around = match (&domain, &planes, &parts, &seals, &bodies) {
        (Some(domain), Some(planes), Some(parts), Some(surfaces), Some(bodies)) => {
            Some(Surroundings { domain, planes, parts, surfaces, bodies })
        }
        _ => None,
    };
    let contacts = contacts(table, around.as_ref(), findings);
    Some(Scene {
        gravity: table.gravity?.map(|g| g.0),
        fluid: flatten(fluid)?,
        contacts: contacts?,
        domain: domain?,
        planes: planes?,
        parts: parts?,
        surfaces: seals?,
        unions: unions?,
        shapes: shapes.used(bodies.iter().flatten().map(|set| &set.placement)),
        bodies: bodies?,
        inlets: inlets?,
        outlets: outlets?,
        drag_bands: drag_bands?,
        followed: bodies::followed(&table.bodies, findings)?,
        probes: probes?,
        profiles: profiles?,
        gaps: gaps?,
    })
}

/// `None` only where something is there and wrong.
fn flatten<T>(value: Option<Option<T>>) -> Option<Option<T>> {
    match value {
        Some(Some(value)) => Some(Some(value)),
        Some(None) => None,
        None => Some(None),
    }
}

fn planes(tables: &[PlaneTable], findings: &mut Findings) -> Option<Vec<Plane>> {
    let planes: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| plane(table, &path::item("scene.planes", i), findings))
        .collect();
    planes.into_iter().collect()
}

fn plane(table: &PlaneTable, at: &str, findings: &mut Findings) -> Option<Plane> {
    let point = findings.required(&table.point, at, "point");
    let normal = findings.required(&table.normal, at, "normal")?;
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    if !(length.is_normal() && length.is_finite()) {
        findings.problem(
            &path::join(at, "normal"),
            format!("found {normal:?}, expected a direction, which has a length"),
        );
        return None;
    }
    Some(Plane {
        point: point?.map(|p| p.0),
        normal: normal.map(|n| n / length),
        material: table.material.clone().unwrap_or_else(|| Domain::MATERIAL.into()),
    })
}
