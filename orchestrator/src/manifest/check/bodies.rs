//! Checks of `[[scene.bodies]]`, set by set.

use super::super::document::{BodiesTable, ClumpMass, LatticeTable, PackingTable, SphereTable};
use super::super::path;
use super::super::read::Findings;
use super::course::motion;
use super::diameters::diameters;
use super::lattice;
use super::point;
use super::polyhedra::{self, Shapes};
use std::collections::BTreeSet;
use tremie_messages::finding::short;
use tremie_messages::scene::{
    BodySet, Motion, Packing, Placement, Polyhedra, Polyhedron, PolyhedronPlacement, Sphere,
};

/// Spheres of one size fill no more than this of a space (Kepler); random ones far less.
const DENSEST: f64 = 0.7405;

/// The sets; `None` for each that is wrong.
pub(super) fn bodies(
    tables: &[BodiesTable],
    shapes: &Shapes,
    findings: &mut Findings,
) -> Vec<Option<BodySet>> {
    let mut names = BTreeSet::new();
    (tables.iter().enumerate())
        .map(|(i, table)| {
            let at = path::item("scene.bodies", i);
            body_set(table, (shapes, &at), &mut names, findings)
        })
        .collect()
}

fn body_set(
    table: &BodiesTable,
    (shapes, at): (&Shapes, &str),
    names: &mut BTreeSet<String>,
    findings: &mut Findings,
) -> Option<BodySet> {
    let name = findings.required(&table.name, at, "name");
    if let Some(name) = &name
        && !names.insert(name.clone())
    {
        findings.problem_with_help(
            &path::join(at, "name"),
            format!("a second set of bodies with the name \"{name}\""),
            "give it another name: laws of contact and signals name a set by it",
        );
    }
    let density = density(table, at, findings);
    let motion = motion(table.motion?, table.course.as_ref(), at, findings);
    let placement = placement(table, shapes, at, findings);
    let listed = if table.prisms.is_some() { "prisms" } else { "polyhedra" };
    one_velocity(&motion, &placement, (at, listed), findings);
    Some(BodySet {
        material: table.material.clone().or_else(|| name.clone())?,
        name: name?,
        density: density?,
        motion: motion?,
        clump: table.clump.clone(),
        placement: placement?,
    })
}

/// The clumps whose mass is that of the union of their bodies; `None` where sets say what does not
/// fit together.
pub(super) fn unions(tables: &[BodiesTable], findings: &mut Findings) -> Option<Vec<String>> {
    let mut said: Vec<(&str, ClumpMass, usize)> = Vec::new();
    let mut fits = true;
    for (i, table) in tables.iter().enumerate() {
        let Some(mass) = table.mass else { continue };
        let at = path::join(&path::item("scene.bodies", i), "mass");
        let Some(clump) = table.clump.as_deref() else {
            let message = "found the mass of a clump, but these bodies are in none";
            let help = "give them a clump, or leave it out: a body weighs density times volume";
            findings.problem_with_help(&at, message, help);
            fits = false;
            continue;
        };
        match said.iter().find(|(name, ..)| *name == clump) {
            Some((_, other, set)) if *other != mass => {
                let message =
                    format!("scene.bodies[{set}] of the same clump \"{clump}\" says otherwise");
                findings.problem(&at, message);
                fits = false;
            }
            Some(_) => {}
            None => said.push((clump, mass, i)),
        }
    }
    let united = said.into_iter().filter(|(_, mass, _)| *mass == ClumpMass::Union);
    fits.then(|| united.map(|(name, ..)| name.to_string()).collect())
}

/// Most bodies of a set that can be followed.
const MOST_FOLLOWED: usize = 64;

/// Names of the sets and clumps whose motion is to be told.
pub(super) fn followed(tables: &[BodiesTable], findings: &mut Findings) -> Option<Vec<String>> {
    let mut names = Vec::new();
    let mut right = true;
    for (i, table) in tables.iter().enumerate().filter(|(_, table)| table.follow == Some(true)) {
        let round = table.spheres.as_ref().or(table.cylinders.as_ref());
        let count = match (round, &table.polyhedra, &table.prisms) {
            (Some(list), ..) => list.len(),
            (_, Some(list), _) => list.len(),
            (.., Some(list)) => list.len(),
            (None, None, None) => usize::MAX,
        };
        if table.clump.is_none() && count > MOST_FOLLOWED {
            let key = path::join(&path::item("scene.bodies", i), "follow");
            let found =
                if count == usize::MAX { "no list".into() } else { format!("{count} bodies") };
            let message = format!(
                "found {found}, but only sets that list {MOST_FOLLOWED} bodies at most can be followed one by one"
            );
            let help = "list the ones of interest in a set of their own; the recording has the paths of all";
            findings.problem_with_help(&key, message, help);
            right = false;
        }
        let name = table.clump.as_ref().or(table.name.as_ref());
        if let Some(name) = name.filter(|name| !names.contains(*name)) {
            names.push(name.clone());
        }
    }
    right.then_some(names)
}

/// The density of a set; where it has none of its own, that of its material was filled in before.
fn density(table: &BodiesTable, at: &str, findings: &mut Findings) -> Option<f64> {
    if table.density.is_some() {
        return findings.positive(&table.density, at, "density");
    }
    let material = table.material.as_deref().unwrap_or_default();
    let source = path::join(&path::join("scene.materials", material), "density");
    let key = path::join(at, "density");
    if !findings.is_unreadable(&key) && !findings.is_unreadable(&source) {
        let message = format!("missing: {at} needs a key \"density\"");
        let help = format!("add it here or to [scene.materials.{material}]");
        findings.problem_with_help(&key, message, help);
    }
    None
}

/// A course says how fast bodies are: they cannot be placed with another velocity.
fn one_velocity(
    motion: &Option<Motion>,
    placement: &Option<Placement>,
    (at, of_shape): (&str, &'static str),
    findings: &mut Findings,
) {
    let Some(Motion::Prescribed(points)) = motion else { return };
    let turns = |v: [f64; 3], w: [f64; 3]| v != [0.0; 3] || w != [0.0; 3];
    let (key, moving) = match placement {
        Some(Placement::Listed(spheres)) => {
            let moves = |s: &Sphere| turns(s.velocity, s.angular_velocity);
            ("spheres", spheres.iter().position(moves))
        }
        Some(Placement::Polyhedra(Polyhedra {
            placement: PolyhedronPlacement::Listed(list),
            ..
        })) => {
            let moves = |s: &Polyhedron| turns(s.velocity, s.angular_velocity);
            (of_shape, list.iter().position(moves))
        }
        _ => return,
    };
    if let Some(i) = moving.filter(|_| !points.is_empty()) {
        let message =
            "found a velocity, but the set has a course, which says how fast its bodies are";
        findings.problem(&path::item(&path::join(at, key), i), message);
    }
}

fn placement(
    table: &BodiesTable,
    shapes: &Shapes,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    let key = if table.cylinders.is_some() { "cylinders" } else { "spheres" };
    if table.cylinders.is_some() && table.spheres.is_some() {
        let message = "found both spheres and cylinders, expected one of them";
        findings.problem(&path::join(at, key), message);
        return None;
    }
    let round = table.cylinders.as_ref().or(table.spheres.as_ref());
    if table.prisms.is_some() {
        return prisms(table, shapes, at, findings);
    }
    if let Some(lattice) = &table.lattice {
        return on_lattice(table, lattice, at, findings);
    }
    match (round, &table.polyhedra, &table.packing) {
        (None, Some(list), None) => polyhedra::listed(table, list, shapes, at, findings),
        (Some(_), None, None) if table.shape.is_some() => {
            let message =
                format!("found a shape, but the bodies are {key}: expected \"polyhedra\"");
            findings.problem(&path::join(at, "shape"), message);
            None
        }
        (Some(spheres), None, None) => {
            let at = path::join(at, key);
            let spheres: Vec<_> = (spheres.iter().enumerate())
                .map(|(i, table)| sphere(table, &path::item(&at, i), findings))
                .collect();
            spheres.into_iter().collect::<Option<_>>().map(Placement::Listed)
        }
        (None, None, Some(packed)) => {
            let packing = packing(packed, &path::join(at, "packing"), findings)?;
            match &table.shape {
                Some(shape) => polyhedra::packed(shape, packing, shapes, at, findings),
                None => Some(Placement::Packed(packing)),
            }
        }
        (None, None, None) => {
            let keys = ["spheres", "cylinders", "polyhedra", "prisms", "lattice", "packing"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                let message = "missing: where the bodies are, as \"spheres\", \"polyhedra\", \"lattice\" or \"packing\"";
                findings.problem(at, message);
            }
            None
        }
        (_, _, Some(_)) => {
            let other = if round.is_some() { key } else { "polyhedra" };
            findings.problem(
                &path::join(at, "packing"),
                format!("found both {other} and a packing, expected one of them"),
            );
            None
        }
        (Some(_), Some(_), None) => {
            findings.problem(
                &path::join(at, "polyhedra"),
                format!("found both {key} and polyhedra, expected one of them"),
            );
            None
        }
    }
}

/// Spheres on a lattice, and no other bodies beside them.
fn on_lattice(
    table: &BodiesTable,
    lattice: &LatticeTable,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    let key = path::join(at, "lattice");
    let others = [
        ("spheres", table.spheres.is_some()),
        ("cylinders", table.cylinders.is_some()),
        ("polyhedra", table.polyhedra.is_some()),
        ("packing", table.packing.is_some()),
        ("a shape", table.shape.is_some()),
    ];
    if let Some((other, _)) = others.into_iter().find(|(_, is_there)| *is_there) {
        let message = format!("found both {other} and a lattice of spheres, expected one of them");
        findings.problem(&key, message);
        return None;
    }
    lattice::spheres(lattice, &key, findings).map(Placement::Listed)
}

/// Prisms, and no other bodies beside them.
fn prisms(
    table: &BodiesTable,
    shapes: &Shapes,
    at: &str,
    findings: &mut Findings,
) -> Option<Placement> {
    let others = [
        ("spheres", table.spheres.is_some()),
        ("cylinders", table.cylinders.is_some()),
        ("polyhedra", table.polyhedra.is_some()),
        ("lattice", table.lattice.is_some()),
        ("packing", table.packing.is_some()),
    ];
    if let Some((other, _)) = others.into_iter().find(|(_, is_there)| *is_there) {
        let message = format!("found both prisms and {other}, expected one of them");
        findings.problem(&path::join(at, "prisms"), message);
        return None;
    }
    polyhedra::prisms(table, table.prisms.as_deref()?, shapes, at, findings)
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
pub(super) fn region_holds(
    min: &[f64; 3],
    max: &[f64; 3],
    diameter: f64,
    at: &str,
    findings: &mut Findings,
) {
    let narrowest = (0..3).map(|a| max[a] - min[a]).fold(f64::INFINITY, f64::min);
    let key = path::join(at, "max");
    if narrowest <= 0.0 {
        findings.problem(
            &key,
            format!(
                "found {} m, expected more than the lower corner {} m along each axis",
                point(max),
                point(min)
            ),
        );
    } else if narrowest < diameter * (1.0 - 1e-9) {
        let message = format!(
            "the region is {} m wide, too narrow for spheres of {} m",
            short(narrowest),
            short(diameter)
        );
        findings.problem(&key, message);
    }
}
