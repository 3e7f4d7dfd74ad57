//! Checks of `[components]` and their settings.

use super::super::document::{ComponentTable, Document, PartMotionEntry, PartTable};
use super::super::path;
use super::super::read::Findings;
use super::super::spec::{ComponentSpec, MOST_SUBSTEPS, stem};
use crate::manifest::ORCHESTRATOR;
use crate::registry::settings_shared_with;
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use tremie_messages::Role;

pub(super) fn components(
    document: &Document,
    findings: &mut Findings,
) -> Option<Vec<ComponentSpec>> {
    let components: Vec<_> = (document.components.iter())
        .map(|(name, entry)| component(name, &entry.table(), &document.settings, findings))
        .collect();
    let components: Vec<ComponentSpec> = components.into_iter().collect::<Option<_>>()?;
    together(&components, document, findings).then_some(components)
}

fn component(
    name: &str,
    table: &ComponentTable,
    settings: &BTreeMap<String, Map<String, Value>>,
    findings: &mut Findings,
) -> Option<ComponentSpec> {
    let at = path::join("components", name);
    let named = is_name(name, &at, findings);
    let program = program(table, &at, findings);
    let role = role(table, &at, findings);
    let sync_iter = sync_iter(table, &at, findings);
    if table.lossless.is_some() && role.is_some_and(|role| role != Role::Observer) {
        findings.problem(&path::join(&at, "lossless"), "only an observer can be lossless or not");
    }
    if table.sync_iter.is_some() && role == Some(Role::Observer) {
        findings.problem(&path::join(&at, "sync_iter"), "an observer makes no substeps");
    }
    if let Some((own, other)) = role.and_then(|own| Some((own, own.steps_with()?)))
        && table.sync_iter.is_some()
    {
        let message =
            format!("a {own} makes the substeps of the {other}, expected no number of its own");
        let help = format!("give it to the {other}");
        findings.problem_with_help(&path::join(&at, "sync_iter"), message, help);
    }
    // Only now, so that a missing program hides no other problem.
    let program = program?;
    let of = |program: &str| settings.get(program).cloned().unwrap_or_default();
    let mut own = settings_shared_with(stem(&program)).map_or_else(Map::new, of);
    own.extend(of(stem(&program)));
    own.extend(table.settings.clone().unwrap_or_default());
    Some(ComponentSpec {
        name: named.then(|| name.to_string())?,
        role: role?,
        program,
        threads: table.threads.map(NonZeroU32::get),
        sync_iter: sync_iter?,
        lossless: table.lossless.unwrap_or(false),
        settings: own,
    })
}

/// Names become parts of the names of channels and of keys.
fn is_name(name: &str, at: &str, findings: &mut Findings) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name == ORCHESTRATOR {
        findings.problem(at, "this name is the orchestrator's own, expected another");
    } else if name.is_empty() || !name.chars().all(plain) {
        findings.problem(
            at,
            format!("found the name \"{name}\", expected letters, digits, \"-\" and \"_\""),
        );
    } else {
        return true;
    }
    false
}

fn program(table: &ComponentTable, at: &str, findings: &mut Findings) -> Option<String> {
    let program = findings.required(&table.program, at, "program")?;
    if program.trim().is_empty() {
        findings.problem(
            at,
            "found no program, expected a built-in component or the path of a program",
        );
        return None;
    }
    Some(program)
}

fn role(table: &ComponentTable, at: &str, findings: &mut Findings) -> Option<Role> {
    let key = path::join(at, "role");
    if table.role.is_none() && !findings.is_unreadable(&key) {
        findings.problem_with_help(
            &key,
            "missing: what the component stands for; its name does not say it",
            "add role = \"fluid\", \"grains\", \"rubber\" or \"observer\"",
        );
    }
    table.role
}

fn sync_iter(table: &ComponentTable, at: &str, findings: &mut Findings) -> Option<Option<u32>> {
    let sync_iter = table.sync_iter.map(NonZeroU32::get);
    match sync_iter {
        Some(n) if n > MOST_SUBSTEPS => {
            let key = path::join(at, "sync_iter");
            findings.problem(
                &key,
                format!("found {n}, expected at most {MOST_SUBSTEPS} substeps in a window"),
            );
            None
        }
        _ => Some(sync_iter),
    }
}

/// True if there are grains where parts move: they announce the parts and say where they are.
fn moved(document: &Document, grains: bool, findings: &mut Findings) -> bool {
    if grains || findings.is_unreadable("components") {
        return true;
    }
    let moves = |part: &PartTable| part.motion.as_ref().is_some_and(PartMotionEntry::moves);
    let first = document.scene.parts.iter().position(moves);
    if let Some(i) = first {
        let key = path::join(&path::item("scene.parts", i), "motion");
        findings.problem_with_help(
            &key,
            "nobody moves this part: there is no component with the role grains",
            "add grains = \"grains-dem\" to [components]",
        );
    }
    first.is_none()
}

/// True if surfaces and a rubber to shape them are both there, or neither; and grains to carry
/// them.
fn shaped(
    document: &Document,
    rubber: Option<&ComponentSpec>,
    grains: Option<&ComponentSpec>,
    findings: &mut Findings,
) -> bool {
    let has_surface = !document.scene.surfaces.is_empty();
    let (key, message, help) = match rubber {
        None if has_surface && !findings.is_unreadable("components") => (
            path::item("scene.surfaces", 0),
            "nobody shapes this surface: there is no component with the role rubber",
            "add rubber = \"rubber-table\" to [components]",
        ),
        Some(rubber) if !has_surface && !findings.is_unreadable("scene.surfaces") => (
            rubber.key(),
            "a rubber needs a surface to shape, and the scene has none",
            "add [[scene.surfaces]] with name, carrier and table",
        ),
        Some(rubber) if grains.is_none() && !findings.is_unreadable("components") => (
            rubber.key(),
            "a rubber needs grains, which move its carrier and find its contacts; there is no component with the role grains",
            "add grains = \"grains-dem\" to [components]",
        ),
        _ => return true,
    };
    findings.problem_with_help(&key, message, help);
    false
}

/// Checks of all components together; true if they are right.
fn together(components: &[ComponentSpec], document: &Document, findings: &mut Findings) -> bool {
    let of = |role| components.iter().filter(move |component| component.role == role);
    let mut right = true;
    for role in Role::PHYSICS {
        if let Some(second) = of(role).nth(1) {
            let first = of(role).next().map_or("", |component| &component.name);
            findings.problem_with_help(
                &second.key(),
                format!("a second component with the role {role}, which {first} has"),
                format!("leave one of the two out: a run has one {role}"),
            );
            right = false;
        }
    }
    if let Some(fluid) = of(Role::Fluid).next()
        && document.scene.fluid.is_none()
        && !findings.is_unreadable("scene.fluid")
    {
        let message = "a fluid needs a material, and the scene has none";
        findings.problem_with_help(
            &fluid.key(),
            message,
            "add [scene.fluid] with density and viscosity",
        );
        right = false;
    }
    right &= moved(document, of(Role::Grains).next().is_some(), findings);
    right &= shaped(document, of(Role::Rubber).next(), of(Role::Grains).next(), findings);
    let physics = components.iter().any(|component| component.role != Role::Observer);
    if !physics && !findings.is_unreadable("components") {
        findings.problem_with_help(
            "components",
            "there is nothing to compute: no component with the role fluid or grains",
            "name one, as grains = \"grains-dem\"",
        );
    }
    right && physics
}
