//! Changes of the manifest from a window on: which are sound, and the changed manifest.
//!
//! A run takes a change where it goes on from a checkpoint. What a state holds cannot change: bodies,
//! cells, steps. What holds from then on can: how long, outputs, the order of work, what drives the physics,
//! friction.

use crate::manifest::{self, ComponentSpec, Manifest, ManifestErrors};
use crate::registry::settings_shared_with;
use crate::run::origin::Takes;
use std::collections::BTreeSet;
use std::path::Path;
use tremie_messages::Role;

/// Keys that may change, and all below them; `*` stands for any one key, `[]` for any entry of a list.
const MAY_CHANGE: &[&str] = &[
    "run.until",
    "run.deadline",
    "run.start_within",
    "run.checkpoints",
    "run.schedule",
    "outputs",
    "stop_when",
    "watch",
    "components.*.threads",
    "scene.gravity",
    "scene.fluid.viscosity",
    "scene.fluid.acceleration",
    "scene.domain.*.*.velocity",
    "scene.domain.*.*.pressure",
    "scene.domain.*.*.course",
    "scene.domain.*.*.reservoir.piston",
    "scene.domain.*.*.reservoir.course",
    "scene.domain.*.*.reservoir.stop",
    "scene.parts[].boundary.reservoir.piston",
    "scene.parts[].boundary.reservoir.course",
    "scene.parts[].boundary.reservoir.stop",
    "scene.parts[].velocity",
    "scene.parts[].angular_velocity",
    "scene.parts[].course",
    "scene.bodies[].course",
    "scene.contacts[].friction",
    "scene.contacts[].rolling_friction",
    "scene.contacts[].restitution",
    "settings.*.mach_limit",
    "settings.*.smagorinsky",
    "settings.*.tolerance",
    "settings.*.iterations",
    "settings.*.launch",
    "settings.*.deadline",
    "settings.viewer",
];

/// What a run that begins from the checkpoint of another may have otherwise besides: it has outputs of its
/// own.
const OWN_OUTPUTS: &[&str] = &["settings.recorder", "settings.fields", "settings.profiles"];

/// What besides may be otherwise in a run that begins with the bodies of another.
const BESIDE_BODIES: &[&str] = &[
    "components",
    "run",
    "settings",
    "scene.fluid",
    "scene.domain.x",
    "scene.domain.y",
    "scene.domain.z",
    "scene.drag_bands",
    "scene.gaps",
    "scene.inlets[].until",
    "scene.parts[].boundary",
    "scene.probes",
    "scene.profiles",
];

/// Why a manifest was not changed.
#[derive(Debug, thiserror::Error)]
pub enum NotChanged {
    /// The changed manifest is wrong.
    #[error(transparent)]
    Wrong(ManifestErrors),
    /// The run's states depend on what would change.
    #[error("{} cannot change from a checkpoint on, because states depend on it; what can: {}", keys.join(", "), MAY_CHANGE.join(", "))]
    Fixed {
        /// The keys.
        keys: Vec<String>,
    },
    /// A run cannot begin with the bodies of another.
    #[error("{} must be as in the run of the checkpoint: this run has other components, so it begins with the bodies of that one; what may differ: {}", keys.join(", "), [MAY_CHANGE, BESIDE_BODIES].concat().join(", "))]
    Bodies {
        /// Keys that differ.
        keys: Vec<String>,
    },
    /// Runs of different components have no grains in common.
    #[error(
        "this run has other components than that of the checkpoint, and no grains of the same name and program with whose bodies it could begin"
    )]
    NoGrains,
}

/// The manifest of a run, its `text` as resolved, with `sets` laid over it from a window on; `file` is what
/// messages call it.
///
/// # Errors
/// [`NotChanged`].
pub fn changed(file: &Path, text: &str, sets: &[(String, String)]) -> Result<Manifest, NotChanged> {
    let read = |sets| manifest::parse(file, text.into(), sets).map_err(NotChanged::Wrong);
    let (before, changed) = (read(&[])?, read(sets)?);
    only(MAY_CHANGE, differences(&before, &changed)).map(|()| changed)
}

/// What a run of `manifest` takes of a checkpoint of another run, whose manifest as resolved is `text`;
/// `file` is what messages call it. With the components of that run it goes on from their states. With
/// others it begins with the bodies of the grains.
///
/// # Errors
/// [`NotChanged`].
pub fn branch(file: &Path, text: &str, manifest: &Manifest) -> Result<Takes, NotChanged> {
    let before = manifest::parse(file, text.into(), &[]).map_err(NotChanged::Wrong)?;
    let keys = differences(&before, manifest);
    if physics(&before) == physics(manifest) {
        return only(&[MAY_CHANGE, OWN_OUTPUTS].concat(), keys).map(|()| Takes::States);
    }
    let grains = manifest.spec.components.iter().find(|component| component.role == Role::Grains);
    let Some(grains) = grains.filter(|grains| physics(&before).contains(&part(grains))) else {
        return Err(NotChanged::NoGrains);
    };
    // Across faces of a periodic axis bodies touch.
    let domains = [&before, manifest].map(|manifest| &manifest.spec.scene.domain);
    let other_axis =
        (0..3).find(|axis| domains[0].is_periodic(*axis) != domains[1].is_periodic(*axis));
    let periodic = other_axis.map(|axis| format!("scene.domain.{}", ["x", "y", "z"][axis]));
    let own = [format!("components.{}", grains.name), format!("settings.{}", grains.stem())];
    let depends = |key: &String| {
        let is_own = own.iter().any(|own| is_within(key, own)) && !is_of_work(key);
        let may = [MAY_CHANGE, OWN_OUTPUTS, BESIDE_BODIES].concat();
        Some(key) == periodic.as_ref() || is_own || !may.iter().any(|may| is_within(key, may))
    };
    let keys: Vec<String> = keys.into_iter().filter(depends).collect();
    if keys.is_empty() { Ok(Takes::Bodies) } else { Err(NotChanged::Bodies { keys }) }
}

/// Keys in which two manifests differ. Where a program gives way to one that keeps the same states, the settings of
/// both count as they take effect.
fn differences(before: &Manifest, after: &Manifest) -> Vec<String> {
    let mut keys = manifest::differences(&before.tables(), &after.tables());
    if physics(before) != physics(after) {
        return keys;
    }
    let pairs = components(before).zip(components(after));
    for (old, new) in pairs.filter(|(old, new)| old.program != new.program) {
        let own = format!("components.{}.program", new.name);
        let fellows = [old, new].map(ComponentSpec::stem);
        let fellows = fellows.into_iter().filter(|stem| settings_shared_with(stem).is_some());
        let tables: Vec<String> = fellows.map(|stem| format!("settings.{stem}")).collect();
        keys.retain(|key| *key != own && !tables.iter().any(|table| is_within(key, table)));
        let settings: BTreeSet<&String> = old.settings.keys().chain(new.settings.keys()).collect();
        let differ =
            settings.into_iter().filter(|&key| old.settings.get(key) != new.settings.get(key));
        keys.extend(differ.map(|key| format!("settings.{}.{key}", new.stem())));
    }
    keys
}

/// Components of the physics, in the order of the manifest.
fn components(manifest: &Manifest) -> impl Iterator<Item = &ComponentSpec> {
    manifest.spec.components.iter().filter(|component| component.role != Role::Observer)
}

fn physics(manifest: &Manifest) -> Vec<(Role, &str, &str)> {
    components(manifest).map(part).collect()
}

/// A component's role, name and program, or the program whose settings and states that has.
fn part(component: &ComponentSpec) -> (Role, &str, &str) {
    let program = settings_shared_with(component.stem()).unwrap_or(&component.program);
    (component.role, &component.name, program)
}

/// True of keys that say how a component works and not what it does.
fn is_of_work(key: &str) -> bool {
    ["components.*.threads", "components.*.sync_iter"].iter().any(|work| is_within(key, work))
}

/// Checks that all `keys` may change.
fn only(may: &[&str], mut keys: Vec<String>) -> Result<(), NotChanged> {
    keys.retain(|key| !may.iter().any(|pattern| is_within(key, pattern)));
    if keys.is_empty() { Ok(()) } else { Err(NotChanged::Fixed { keys }) }
}

/// True if a key matches a pattern, or lies below what does.
fn is_within(key: &str, pattern: &str) -> bool {
    let mut keys = key.split('.');
    let mut whole = true;
    pattern.split('.').all(|expected| {
        let Some(found) = keys.next().filter(|_| whole) else { return false };
        let (found, index) = found.split_once('[').map_or((found, ""), |(name, rest)| (name, rest));
        // An entry that is meant as any of a list; else a list's entry lies below the list.
        let (expected, of_list) = match expected.strip_suffix("[]") {
            Some(name) => (name, true),
            None => (expected, false),
        };
        whole = index.is_empty() || of_list;
        (expected == "*" || expected == found) && (!of_list || !index.is_empty())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_lies_within_its_tables_only() {
        assert!(is_within("outputs.frames", "outputs") && is_within("outputs", "outputs"));
        assert!(
            is_within("stop_when[0].above", "stop_when") && is_within("stop_when", "stop_when")
        );
        assert!(!is_within("outputs_of", "outputs") && !is_within("run", "run.until"));
    }

    /// A box of water.
    const WATER: &str = r#"
        [run]
        until = "1 s"
        [scene.domain]
        size = ["1 m", "1 m", "1 m"]
        [scene.fluid]
        density = "1 kg/m3"
        viscosity = "1 Pa s"
        [components]
        fluid = "fluid-lbm"
        [settings.fluid-lbm]
        cell = "10 cm"
    "#;

    fn changed_by(text: &str, sets: &[(&str, &str)]) -> Result<Manifest, NotChanged> {
        let sets = sets.iter().map(|(key, value)| (key.to_string(), value.to_string()));
        changed(Path::new("manifest.toml"), text, &sets.collect::<Vec<_>>())
    }

    #[test]
    fn a_program_gives_way_to_one_that_keeps_the_same_states() {
        let with = |sets: &[(&str, &str)]| changed_by(WATER, sets);
        let launch = ("settings.fluid-lbm-mpi.launch", r#"["mpiexec", "-n", "2"]"#);
        let on_ranks = with(&[("components.fluid", "fluid-lbm-mpi"), launch]).unwrap();
        assert_eq!(on_ranks.spec.components[0].program, "fluid-lbm-mpi");
        let words = |error: NotChanged| error.to_string();
        let other = words(with(&[("components.fluid", "fluid-pic")]).map(drop).unwrap_err());
        assert!(other.starts_with("components.fluid.program cannot change"), "{other}");
        let to_ranks = ("components.fluid.program", "fluid-lbm-mpi");
        // Settings that only the new program has would be another lattice as much as changed ones.
        for (key, value) in [("fluid-lbm.cell", "5 cm"), ("fluid-lbm-mpi.magic", "0.1")] {
            let key = format!("settings.{key}");
            let refused = words(with(&[to_ranks, launch, (&key, value)]).map(drop).unwrap_err());
            let name = key.replace("fluid-lbm.", "fluid-lbm-mpi.");
            assert!(refused.contains(&key) || refused.contains(&name), "{refused}");
        }
    }

    #[test]
    fn settings_of_ranks_alone_are_not_lost_where_one_process_goes_on() {
        let ranks = r#"{ program = "./build/fluid-lbm-mpi", role = "fluid" }"#;
        let text = WATER.replace("\"fluid-lbm\"", ranks);
        let launch = r#"[settings.fluid-lbm-mpi]
            launch = ["mpiexec", "-n", "2"]"#;
        let back = [("components.fluid.program", "fluid-lbm")];
        let with = |magic| changed_by(&format!("{text}\n{launch}\n{magic}\n"), &back);
        assert_eq!(with("").unwrap().spec.components[0].program, "fluid-lbm");
        let refused = with("magic = 0.1").map(drop).unwrap_err().to_string();
        assert!(refused.starts_with("settings.fluid-lbm.magic cannot change"), "{refused}");
    }

    #[test]
    fn patterns_name_any_key_and_any_entry() {
        let may_change = |key: &str| MAY_CHANGE.iter().any(|pattern| is_within(key, pattern));
        assert!(may_change("scene.domain.x.lower.reservoir.piston"));
        assert!(may_change("scene.contacts[3].friction") && may_change("scene.gravity[2]"));
        assert!(may_change("scene.parts[0].course[1].velocity[0]"));
        assert!(
            may_change("settings.fluid-pic.tolerance") && may_change("components.fluid.threads")
        );
        for key in [
            "scene.contacts",
            "scene.contacts[3]",
            "scene.contacts[3].normal_stiffness",
            "scene.domain.x.lower.reservoir.volume",
            "scene.domain.size[0]",
            "components.fluid.program",
            "run.seed",
            "settings.fluid-lbm.cell",
        ] {
            assert!(!may_change(key), "{key}");
        }
    }
}
