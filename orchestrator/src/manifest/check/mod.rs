//! Typed tables to a checked [`Spec`]: required keys, ranges, and what must fit together.
//!
//! Each check notes its problems and returns `None` where it has no value to go on with.

mod bodies;
mod chen;
mod components;
mod contacts;
mod course;
mod diameters;
mod domain;
mod drag_bands;
mod fluid;
mod gaps;
mod gas;
mod hoppers;
mod inlets;
mod lattice;
mod materials;
mod near;
mod parts;
mod placement;
mod plane;
mod polyhedra;
mod probes;
mod profiles;
mod rough_walls;
mod run;
mod scene;
mod seals;
mod slider;
mod surfaces;
mod watch;

use super::document::Document;
use super::path;
use super::read::Findings;
use super::spec::Spec;
use crate::registry::settings_shared_with;
use std::collections::BTreeSet;
use tremie_messages::finding::short;
use tremie_messages::scene::{Domain, Probe, ProbeShape};
use tremie_messages::units::{
    Area, Dashpot, Density, Frequency, Length, Mass, Pressure, Stiffness, Temperature, Time,
    Velocity, Viscosity, Volume,
};
use tremie_messages::{Problem, Role};

/// Checks a document with its defaults filled in.
pub(super) fn check(document: &Document, findings: &mut Findings) -> Option<Spec> {
    let run = run::run(&document.run, findings);
    let outputs = run::outputs(&document.outputs, findings);
    let scene = scene::scene(&document.scene, findings);
    if let (Some(scene), Some(run)) = (&scene, &run) {
        profiles::fit(scene, run, findings);
    }
    let components = components::components(document, findings);
    let stop_when = run::stops(document, findings);
    let watch = watch::watch(&document.watch, findings);
    Some(Spec {
        run: run?,
        scene: scene?,
        components: components?,
        settings: document.settings.clone(),
        outputs: outputs?,
        stop_when: stop_when?,
        watch: watch?,
    })
}

/// Notes on keys that are right but may not be meant.
pub(super) fn notes(spec: &Spec) -> Vec<String> {
    let built_in_observers = ["viewer", "recorder", "fields", "profiles"];
    let is_used = |program: &str| {
        let all = spec.components.iter().map(|component| component.stem());
        all.into_iter().any(|stem| stem == program || settings_shared_with(stem) == Some(program))
    };
    let mut notes: Vec<String> = (spec.settings.keys())
        .filter(|program| !is_used(program) && !built_in_observers.contains(&program.as_str()))
        .map(|program| format!("settings.{program} is not used: no component runs that program"))
        .collect();
    let has = |role| spec.components.iter().any(|c| c.role == role);
    if spec.scene.fluid.is_some() && !has(Role::Fluid) {
        notes.push("scene.fluid is not used: no component has the role fluid".into());
    }
    if let Some(fluid) = &spec.scene.fluid
        && !fluid.inside.is_empty()
        && fluid.outside.is_empty()
    {
        let note = "scene.fluid.inside keeps the fluid that these points reach; whether it leaks out of the parts is \
                    looked at only where scene.fluid.outside has points that it must not reach";
        notes.push(note.into());
    }
    if !spec.scene.probes.is_empty() && !has(Role::Fluid) {
        let areas = |probe: &Probe| {
            matches!(
                probe.shape,
                ProbeShape::Section { .. } | ProbeShape::Region { .. } | ProbeShape::Ring(_)
            )
        };
        let unused = match has(Role::Grains) {
            true if spec.scene.probes.iter().all(areas) => None,
            true => Some("points and lines in scene.probes"),
            false => Some("scene.probes"),
        };
        notes.extend(
            unused.map(|what| format!("{what} are not used: no component has the role fluid")),
        );
    }
    if !spec.scene.bodies.is_empty() && !has(Role::Grains) {
        notes.push("scene.bodies are not used: no component has the role grains".into());
    }
    notes
}

/// A quantity that must not be zero, or not negative, of any unit.
trait Quantity: Copy + std::fmt::Display {
    fn si(self) -> f64;
}

macro_rules! quantities {
    ($($name:ident),+) => {$(
        impl Quantity for $name {
            fn si(self) -> f64 {
                self.0
            }
        }
    )+};
}

quantities!(
    Area,
    Dashpot,
    Density,
    Frequency,
    Length,
    Mass,
    Pressure,
    Stiffness,
    Temperature,
    Time,
    Velocity,
    Viscosity,
    Volume
);

/// What to do about something outside the domain.
const BRING_INSIDE: &str = "move it, or make the domain larger; is its unit right?";

/// A domain's corners, for messages.
fn extent(domain: &Domain) -> String {
    format!("{} m to {} m", point(&domain.min), point(&domain.max))
}

/// A point [m] as a person would write it.
fn point(x: &[f64; 3]) -> String {
    format!("[{}, {}, {}]", short(x[0]), short(x[1]), short(x[2]))
}

impl Quantity for f64 {
    fn si(self) -> f64 {
        self
    }
}

impl Findings {
    /// Notes a problem of one key.
    fn problem(&mut self, key: &str, message: impl Into<String>) {
        self.add(Problem::new(key, message));
    }

    /// Notes a problem of one key, and what to do.
    fn problem_with_help(
        &mut self,
        key: &str,
        message: impl Into<String>,
        help: impl Into<String>,
    ) {
        self.add(Problem::new(key, message).help(help));
    }

    /// The value of a required key of the table `at`.
    fn required<T: Clone>(&mut self, value: &Option<T>, at: &str, key: &str) -> Option<T> {
        if value.is_none() {
            self.missing(at, key);
        }
        value.clone()
    }

    /// Notes that a required key is missing, unless it was there and could not be read.
    fn missing(&mut self, at: &str, key: &str) {
        let full = path::join(at, key);
        if !self.is_unreadable(&full) {
            self.problem(&full, format!("missing: {at} needs a key \"{key}\""));
        }
    }

    /// The name of the table `at`, which becomes part of the names of signals: letters, digits, `_`
    /// and `others`. A second one among `names` is a problem that `taken` words.
    fn name(
        &mut self,
        name: &Option<String>,
        at: &str,
        others: &[char],
        names: &mut BTreeSet<String>,
        taken: impl FnOnce(&str) -> String,
    ) -> Option<String> {
        let name = self.required(name, at, "name")?;
        let key = path::join(at, "name");
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || others.contains(&c);
        if name.is_empty() || !name.chars().all(plain) {
            let others: String = others.iter().map(|c| format!(", \"{c}\"")).collect();
            self.problem(
                &key,
                format!("found \"{name}\", expected letters, digits{others} and \"_\""),
            );
            return None;
        }
        if !names.insert(name.clone()) {
            self.problem(&key, taken(&name));
        }
        Some(name)
    }

    /// The one key of the table `at` that is there; a problem if none is, or more than one. `what`
    /// they say completes the sentence "missing: ...".
    fn only_one(
        &mut self,
        keys: &[(&'static str, bool)],
        what: &str,
        at: &str,
    ) -> Option<&'static str> {
        let mut there = keys.iter().filter(|(_, is_there)| *is_there).map(|(key, _)| *key);
        match (there.next(), there.next()) {
            (Some(one), None) => Some(one),
            (Some(one), Some(other)) => {
                let message = format!("found both {one} and {other}, expected one of them");
                self.problem(&path::join(at, other), message);
                None
            }
            (None, _) => {
                if !self.is_unreadable(at) {
                    let names: Vec<&str> = keys.iter().map(|(key, _)| *key).collect();
                    self.problem(at, format!("missing: {what}, as one of {}", names.join(", ")));
                }
                None
            }
        }
    }

    /// A required quantity above zero, in SI.
    fn positive<T: Quantity>(&mut self, value: &Option<T>, at: &str, key: &str) -> Option<f64> {
        let value = self.required(value, at, key)?;
        self.above_zero(value, &path::join(at, key)).then(|| value.si())
    }

    /// True if `value` of `key` is above zero; a problem if not.
    fn above_zero(&mut self, value: impl Quantity, key: &str) -> bool {
        let right = value.si() > 0.0;
        if !right {
            self.problem(key, format!("found {value}, expected more than zero"));
        }
        right
    }

    /// True if `value` of `key` is zero or above; a problem if not.
    fn not_negative(&mut self, value: impl Quantity, key: &str) -> bool {
        let right = value.si() >= 0.0;
        if !right {
            self.problem(key, format!("found {value}, expected zero or more"));
        }
        right
    }
}
