//! Checks of `[[scene.inlets]]` and `[[scene.outlets]]`.

use super::super::document::{
    BeyondTable, InletTable, InletVelocityEntry, OutletTable, PackingTable, SceneTable, SideName,
};
use super::super::path;
use super::super::read::Findings;
use super::bodies::region_holds;
use super::diameters::diameters;
use std::collections::BTreeSet;
use tremie_messages::scene::{BodySet, Domain, Inlet, InletVelocity, Motion, Outlet, Placement};

/// Names that are taken: they become parts of the names of signals.
pub(super) struct Names(BTreeSet<String>);

impl Names {
    /// Those of the probes.
    pub fn of(scene: &SceneTable) -> Self {
        Self(scene.probes.iter().filter_map(|probe| probe.name.clone()).collect())
    }

    /// The name of the table `at`; a second one of a kind whose signals look alike is a problem.
    pub fn take(
        &mut self,
        name: &Option<String>,
        at: &str,
        findings: &mut Findings,
    ) -> Option<String> {
        let taken = |name: &str| {
            format!("\"{name}\" is the name of another inlet, outlet, probe or drag band")
        };
        findings.name(name, at, &[], &mut self.0, taken)
    }
}

/// The inlets, and the sets of bodies of those that have their own.
pub(super) fn inlets(
    scene: &SceneTable,
    names: &mut Names,
    findings: &mut Findings,
) -> (Option<Vec<Inlet>>, Vec<Option<BodySet>>) {
    let mut sets = Vec::new();
    let inlets: Vec<_> = (scene.inlets.iter().enumerate())
        .map(|(i, table)| {
            let at = path::item("scene.inlets", i);
            let name = names.take(&table.name, &at, findings);
            let bodies = match &table.bodies {
                Some(bodies) => joined(bodies, table, scene, &at, findings),
                None => {
                    sets.push(own_set(&name, table, scene, &at, findings));
                    name.clone()
                }
            };
            inlet(table, (name, bodies), &at, findings)
        })
        .collect();
    (inlets.into_iter().collect(), sets)
}

/// The set that an inlet names.
fn joined(
    bodies: &str,
    table: &InletTable,
    scene: &SceneTable,
    at: &str,
    findings: &mut Findings,
) -> Option<String> {
    for (key, is_there) in
        [("density", table.density.is_some()), ("material", table.material.is_some())]
    {
        if is_there {
            let message = format!("found both bodies and {key}, which is that of the bodies");
            findings.problem(&path::join(at, key), message);
        }
    }
    if !scene.bodies.iter().any(|set| set.name.as_deref() == Some(bodies)) {
        let message = format!("found \"{bodies}\", expected the name of one of scene.bodies");
        findings.problem(&path::join(at, "bodies"), message);
        return None;
    }
    Some(bodies.to_string())
}

/// A set without bodies at the start.
fn own_set(
    name: &Option<String>,
    table: &InletTable,
    scene: &SceneTable,
    at: &str,
    findings: &mut Findings,
) -> Option<BodySet> {
    let density = findings.positive(&table.density, at, "density");
    let name = name.clone()?;
    if scene.bodies.iter().any(|set| set.name.as_ref() == Some(&name)) {
        let message = format!("\"{name}\" is the name of a set of bodies");
        let help = format!("write bodies = \"{name}\" to feed that set, or choose another name");
        findings.problem_with_help(&path::join(at, "name"), message, help);
    }
    Some(BodySet {
        material: table.material.clone()?,
        name,
        density: density?,
        motion: Motion::Free,
        clump: None,
        placement: Placement::Listed(Vec::new()),
    })
}

fn inlet(
    table: &InletTable,
    (name, bodies): (Option<String>, Option<String>),
    at: &str,
    findings: &mut Findings,
) -> Option<Inlet> {
    let min = findings.required(&table.min, at, "min");
    let max = findings.required(&table.max, at, "max");
    let fraction = findings.positive(&table.fraction, at, "fraction");
    let sizes = PackingTable {
        diameter: table.diameter,
        diameters: table.diameters.clone(),
        ..PackingTable::default()
    };
    let diameters = diameters(&sizes, at, findings);
    for (key, time) in [("every", table.every), ("until", table.until)] {
        if let Some(time) = time {
            findings.above_zero(time, &path::join(at, key));
        }
    }
    let velocity = velocity(table, at, findings);
    let (min, max) = (min?.map(|x| x.0), max?.map(|x| x.0));
    let diameters = diameters?;
    region_holds(&min, &max, diameters.extremes()[1], at, findings);
    Some(Inlet {
        name: name?,
        bodies: bodies?,
        min,
        max,
        fraction: fraction?,
        diameters,
        every: table.every.map(|time| time.0),
        velocity: velocity?,
        until: table.until.map(|time| time.0),
        seed: table.seed?,
        tries: table.tries?,
    })
}

fn velocity(table: &InletTable, at: &str, findings: &mut Findings) -> Option<InletVelocity> {
    let key = path::join(at, "velocity");
    match findings.required(&table.velocity, at, "velocity")? {
        InletVelocityEntry::Given(velocity) => Some(InletVelocity::Given(velocity.map(|v| v.0))),
        InletVelocityEntry::Fluid(table) => {
            let (axis, side) = findings.required(&table.face, &key, "face")?.axis_and_side();
            Some(InletVelocity::Face { axis, side })
        }
    }
}

pub(super) fn outlets(
    tables: &[OutletTable],
    domain: Option<&Domain>,
    names: &mut Names,
    findings: &mut Findings,
) -> Option<Vec<Outlet>> {
    let outlets: Vec<_> = (tables.iter().enumerate())
        .map(|(i, table)| {
            let at = path::item("scene.outlets", i);
            let name = names.take(&table.name, &at, findings);
            let beyond = findings.required(&table.beyond, &at, "beyond")?;
            let half = half_space(&beyond, domain, &path::join(&at, "beyond"), findings);
            let ((axis, side), position) = half?;
            Some(Outlet { name: name?, axis, at: position, side })
        })
        .collect();
    outlets.into_iter().collect()
}

/// Axis and side, and where on the axis [m].
fn half_space(
    table: &BeyondTable,
    domain: Option<&Domain>,
    at: &str,
    findings: &mut Findings,
) -> Option<((usize, usize), f64)> {
    if let Some(face) = table.face {
        for (key, is_there) in [
            ("axis", table.axis.is_some()),
            ("at", table.at.is_some()),
            ("side", table.side.is_some()),
        ] {
            if is_there {
                let message = format!("found both face and {key}, expected one of them");
                findings.problem(&path::join(at, key), message);
            }
        }
        let ((axis, side), domain) = (face.axis_and_side(), domain?);
        return Some(((axis, side), [domain.min, domain.max][side][axis]));
    }
    let axis = findings.required(&table.axis, at, "axis");
    let position = findings.required(&table.at, at, "at");
    let side = findings.required(&table.side, at, "side");
    let axis = axis?.number();
    let side = match side? {
        SideName::Lower => 0,
        SideName::Upper => 1,
    };
    Some(((axis, side), position?.0))
}
