//! Checks of `[scene.materials]`, and of the names by which others call them.

use super::super::document::{MaterialTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use std::collections::BTreeSet;
use tremie_messages::scene::Domain;
use tremie_sdk::parameters::nearest;

/// Checks the tables, and that each material that something is made of is known: a table of its
/// own, the name of a set of bodies or of an inlet with its own, or that of the usual walls.
pub(super) fn materials(scene: &SceneTable, findings: &mut Findings) {
    for (name, table) in &scene.materials {
        material(table, &path::join("scene.materials", name), findings);
    }
    let known = known(scene);
    let mut users: Vec<(String, &Option<String>)> =
        vec![("scene.domain.material".into(), &scene.domain.material)];
    let lists: [(&str, Vec<&Option<String>>); 6] = [
        ("scene.planes", scene.planes.iter().map(|plane| &plane.material).collect()),
        ("scene.parts", scene.parts.iter().map(|part| &part.material).collect()),
        ("scene.hoppers", scene.hoppers.iter().map(|hopper| &hopper.material).collect()),
        ("scene.surfaces", scene.surfaces.iter().map(|surface| &surface.material).collect()),
        ("scene.bodies", scene.bodies.iter().map(|set| &set.material).collect()),
        ("scene.inlets", scene.inlets.iter().map(|inlet| &inlet.material).collect()),
    ];
    for (list, names) in lists {
        let key = |i| path::join(&path::item(list, i), "material");
        users.extend(names.into_iter().enumerate().map(|(i, name)| (key(i), name)));
    }
    for (key, name) in users {
        // Defaults repeat the domain's name, whose problem is told there.
        let repeats = key != "scene.domain.material" && *name == scene.domain.material;
        if let Some(name) = name.as_ref().filter(|_| !repeats) {
            is_known(name, &key, &known, findings);
        }
    }
}

fn material(table: &MaterialTable, at: &str, findings: &mut Findings) {
    for (key, value) in [
        ("density", table.density.map(|value| value.0)),
        ("youngs_modulus", table.youngs_modulus.map(|value| value.0)),
    ] {
        let key = path::join(at, key);
        if value.is_some_and(|value| !findings.above_zero(value, &key)) {
            findings.spoil(key);
        }
    }
    if let Some(ratio) = table.poisson_ratio.filter(|ratio| !(*ratio > -1.0 && *ratio <= 0.5)) {
        let message = format!("found {ratio}, expected more than -1 and at most 0.5");
        let key = path::join(at, "poisson_ratio");
        findings.problem(&key, message);
        findings.spoil(key);
    }
}

/// All names that a material may have in this scene.
pub(super) fn known(scene: &SceneTable) -> BTreeSet<&str> {
    let declared = scene.materials.keys().map(String::as_str);
    let own = scene.bodies.iter().filter_map(|set| set.name.as_deref());
    let with_own = scene.inlets.iter().filter(|inlet| inlet.bodies.is_none());
    let fed = with_own.filter_map(|inlet| inlet.name.as_deref());
    declared.chain(own).chain(fed).chain([Domain::MATERIAL]).collect()
}

/// True if `name` is a material; a problem of `key` if not.
pub(super) fn is_known(
    name: &str,
    key: &str,
    known: &BTreeSet<&str>,
    findings: &mut Findings,
) -> bool {
    if known.contains(name) || findings.is_unreadable(&path::join("scene.materials", name)) {
        return true;
    }
    let names: Vec<&str> = known.iter().copied().collect();
    let help = match nearest(name, &names) {
        Some(near) => format!("did you mean \"{near}\"?"),
        None => format!("add [scene.materials.{name}]; known are {}", names.join(", ")),
    };
    findings.problem_with_help(key, format!("there is no material \"{name}\""), help);
    // Nothing else that the material would have given counts as missing.
    findings.spoil(path::join("scene.materials", name));
    false
}
