//! Checks of plane scenes: bodies are cylinders and prisms across the plane, and nothing moves out
//! of it.

use super::super::document::{BodiesTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{BodySet, Domain, Placement, Polyhedra, PolyhedronPlacement};

const AXES: [&str; 3] = ["x", "y", "z"];

/// Notes what does not fit a scene of its kind, and puts the bodies of a plane scene into the
/// plane.
pub(super) fn check(
    table: &SceneTable,
    domain: &Domain,
    bodies: &mut [Option<BodySet>],
    findings: &mut Findings,
) {
    for (i, set) in table.bodies.iter().enumerate() {
        let at = path::item("scene.bodies", i);
        match domain.across {
            Some(axis) => only_across(set, axis, &at, findings),
            None => none_across(set, &at, findings),
        }
    }
    let Some(axis) = domain.across else { return };
    for (key, is_there) in [
        ("inlets", !table.inlets.is_empty()),
        ("outlets", !table.outlets.is_empty()),
        ("surfaces", !table.surfaces.is_empty()),
        ("gaps", !table.gaps.is_empty()),
    ] {
        if is_there {
            let message = "a plane scene has none";
            findings.problem(&path::item(&path::join("scene", key), 0), message);
        }
    }
    let fluid = table.fluid.as_ref();
    let vectors = [
        ("scene.gravity", table.gravity.map(|g| g.map(|g| g.0))),
        ("scene.fluid.velocity", fluid.and_then(|fluid| fluid.velocity).map(|v| v.map(|v| v.0))),
        (
            "scene.fluid.acceleration",
            fluid.and_then(|fluid| fluid.acceleration).map(|a| a.map(|a| a.0)),
        ),
    ];
    for (key, vector) in vectors {
        if let Some(vector) = vector.filter(|vector| vector[axis] != 0.0) {
            leaves_plane(key, &vector, axis, findings);
        }
    }
    let middle = 0.5 * (domain.min[axis] + domain.max[axis]);
    for (i, set) in bodies.iter_mut().enumerate() {
        let at = path::item("scene.bodies", i);
        match set {
            Some(BodySet { placement: Placement::Listed(list), .. }) => {
                for (j, body) in list.iter_mut().enumerate() {
                    let at = path::item(&path::join(&at, "cylinders"), j);
                    stays_in_plane(&at, &body.velocity, &body.angular_velocity, axis, findings);
                    body.position[axis] = middle;
                }
            }
            Some(BodySet {
                placement:
                    Placement::Polyhedra(Polyhedra {
                        placement: PolyhedronPlacement::Listed(list), ..
                    }),
                ..
            }) => {
                for (j, body) in list.iter_mut().enumerate() {
                    let at = path::item(&path::join(&at, "prisms"), j);
                    stays_in_plane(&at, &body.velocity, &body.angular_velocity, axis, findings);
                    body.position[axis] = middle;
                }
            }
            _ => {}
        }
    }
}

/// Notes motions of a body that lead out of the plane.
fn stays_in_plane(
    at: &str,
    velocity: &[f64; 3],
    angular_velocity: &[f64; 3],
    axis: usize,
    findings: &mut Findings,
) {
    if velocity[axis] != 0.0 {
        leaves_plane(&path::join(at, "velocity"), velocity, axis, findings);
    }
    if (0..3).any(|a| a != axis && angular_velocity[a] != 0.0) {
        let message = format!(
            "found {angular_velocity:?} rad/s, but in this plane bodies turn about {} alone",
            AXES[axis]
        );
        findings.problem(&path::join(at, "angular_velocity"), message);
    }
}

/// Notes bodies that only a plane scene has.
fn none_across(set: &BodiesTable, at: &str, findings: &mut Findings) {
    let cases = [
        ("cylinders", set.cylinders.is_some(), "spheres"),
        ("prisms", set.prisms.is_some(), "polyhedra"),
    ];
    for (key, _, instead) in cases.into_iter().filter(|(_, is_there, _)| *is_there) {
        let message = format!("found {key}, but this is no plane scene");
        let help =
            format!("write scene.domain.across = \"y\" for a plane of x and z, or take {instead}");
        findings.problem_with_help(&path::join(at, key), message, help);
    }
}

fn leaves_plane(key: &str, vector: &[f64; 3], axis: usize, findings: &mut Findings) {
    let message =
        format!("found {vector:?}, but along {}, across the plane, nothing moves", AXES[axis]);
    findings.problem_with_help(
        key,
        message,
        "write 0 along this axis, or leave out scene.domain.across",
    );
}

/// Notes bodies that a plane scene does not have.
fn only_across(set: &BodiesTable, axis: usize, at: &str, findings: &mut Findings) {
    let others = [
        ("spheres", set.spheres.is_some()),
        ("polyhedra", set.polyhedra.is_some()),
        ("lattice", set.lattice.is_some()),
        ("packing", set.packing.is_some()),
        ("clump", set.clump.is_some()),
    ];
    for (key, _) in others.into_iter().filter(|(_, is_there)| *is_there) {
        let message = format!(
            "the scene is plane (scene.domain.across = \"{}\"), where bodies are cylinders or prisms",
            AXES[axis]
        );
        let help = "list them as cylinders = [{ position = [...], diameter = \"10 mm\" }] or as prisms, or leave out scene.domain.across";
        findings.problem_with_help(&path::join(at, key), message, help);
    }
}
