//! Checks of where bodies are: inside the domain, on the right side of planes, apart.
//!
//! Bodies at rest on each other do overlap a little; up to a hundredth of a diameter is left to the
//! contact law. Bodies that never move freely may reach into walls and into each other, as the
//! spheres of a rough floor do. So may bodies of one clump into each other. Of polyhedra only the
//! centroid is looked at here: the grains know how far they reach.

use super::super::path;
use super::super::read::Findings;
use super::{BRING_INSIDE, extent, near::Boxes, probes};
use tremie_messages::scene::{
    BodySet, Domain, Face, Motion, Placement, Plane, Polyhedra, PolyhedronPlacement, Sphere,
};

/// Overlap that a contact law may start from, as a fraction of the smaller diameter.
const TOLERANCE: f64 = 0.01;

/// A sphere with what messages need.
struct Placed<'a> {
    at: String,
    sphere: &'a Sphere,
    free: bool,
    clump: Option<&'a str>,
}

/// Notes each listed sphere, and each packing's region, that does not lie where it can.
pub(super) fn check(
    domain: &Domain,
    planes: &[Plane],
    sets: &[Option<BodySet>],
    findings: &mut Findings,
) {
    let round = if domain.across.is_some() { "cylinders" } else { "spheres" };
    let of_shape = if domain.across.is_some() { "prisms" } else { "polyhedra" };
    let mut placed = Vec::new();
    for (i, set) in sets.iter().enumerate() {
        let Some(set) = set else { continue };
        let at = path::item("scene.bodies", i);
        match &set.placement {
            Placement::Listed(spheres) => {
                placed.extend(spheres.iter().enumerate().map(|(j, sphere)| Placed {
                    at: path::item(&path::join(&at, round), j),
                    sphere,
                    free: set.motion == Motion::Free,
                    clump: set.clump.as_deref(),
                }))
            }
            Placement::Polyhedra(Polyhedra {
                placement: PolyhedronPlacement::Listed(list),
                ..
            }) => {
                for (j, body) in list.iter().enumerate() {
                    let key = path::item(&path::join(&at, of_shape), j);
                    let x = body.position;
                    probes::inside(&x, domain, &path::join(&key, "position"), findings);
                }
            }
            Placement::Packed(packing)
            | Placement::Polyhedra(Polyhedra {
                placement: PolyhedronPlacement::Packed(packing),
                ..
            }) => {
                let outside = (0..3)
                    .any(|a| packing.min[a] < domain.min[a] || packing.max[a] > domain.max[a]);
                if outside {
                    let message = format!(
                        "the region reaches out of the domain, which is {}",
                        extent(domain)
                    );
                    findings.problem(&path::join(&at, "packing"), message);
                }
            }
        }
    }
    // Only now, because overlaps are looked for among the spheres of all sets.
    for body in &placed {
        if !cut_by_mirrors(body, domain, findings) {
            inside(body, domain, findings);
        }
        before(body, planes, findings);
    }
    apart(&placed, domain, findings);
}

fn inside(body: &Placed<'_>, domain: &Domain, findings: &mut Findings) {
    let Sphere { position, diameter, .. } = body.sphere;
    let outside = (0..3).filter(|&a| domain.across != Some(a)).any(|a| {
        // Least distance of its centre from the face, inwards.
        let inset = match (domain.is_periodic(a), body.free) {
            (true, _) => 0.0,
            (false, true) => (0.5 - TOLERANCE) * diameter,
            (false, false) => -0.5 * diameter,
        };
        position[a] < domain.min[a] + inset || position[a] > domain.max[a] - inset
    });
    if outside {
        let message = format!(
            "a body of {diameter} m at {position:?} m is not inside the domain, which is {}",
            extent(domain)
        );
        findings.problem_with_help(&path::join(&body.at, "position"), message, BRING_INSIDE);
    }
}

/// Notes a sphere that a symmetry plane cuts and that cannot be its own image: one that moves
/// freely, and one that moves but not within the plane. True if there is such a plane. One that is
/// held at rest may be cut anywhere.
fn cut_by_mirrors(body: &Placed<'_>, domain: &Domain, findings: &mut Findings) -> bool {
    let Sphere { position, diameter, velocity, angular_velocity } = *body.sphere;
    let mut found = false;
    for (a, side) in (0..3).flat_map(|a| [(a, 0), (a, 1)]) {
        if domain.faces[a][side] != Face::Symmetry || domain.across == Some(a) {
            continue;
        }
        let depth = [position[a] - domain.min[a], domain.max[a] - position[a]][side];
        // A sphere before the plane, or wholly beyond it, is not cut by it.
        if depth >= (0.5 - TOLERANCE) * diameter || depth <= -0.5 * diameter {
            continue;
        }
        let face = format!("{}_{}", ["x", "y", "z"][a], ["lower", "upper"][side]);
        let spins = (0..3).any(|b| b != a && angular_velocity[b] != 0.0);
        let moves = velocity != [0.0; 3] || angular_velocity != [0.0; 3];
        let stays = depth.abs() <= 1e-9 * diameter && velocity[a] == 0.0 && !spins;
        let (why, help) = if body.free {
            (
                "it moves freely and would overlap its image",
                "put it half a diameter away from the plane, or hold it: motion = \"fixed\"",
            )
        } else if moves && !stays {
            (
                "it moves, but is not its own image",
                "put its centre on the plane, and let it move along the plane and turn about its normal only",
            )
        } else {
            continue;
        };
        let message = format!(
            "the symmetry plane {face} cuts a sphere of {diameter} m at {position:?} m: {why}"
        );
        findings.problem_with_help(&path::join(&body.at, "position"), message, help);
        found = true;
    }
    found
}

fn before(body: &Placed<'_>, planes: &[Plane], findings: &mut Findings) {
    let Sphere { position, diameter, .. } = body.sphere;
    for (i, plane) in planes.iter().enumerate().filter(|_| body.free) {
        let height: f64 = (0..3).map(|a| (position[a] - plane.point[a]) * plane.normal[a]).sum();
        if height < (0.5 - TOLERANCE) * diameter {
            let message = format!(
                "a body of {diameter} m at {position:?} m reaches through scene.planes[{i}]"
            );
            findings.problem(&path::join(&body.at, "position"), message);
        }
    }
}

/// Notes overlaps: of each sphere with the first one listed before it, so that a pile of errors
/// stays readable.
fn apart(bodies: &[Placed<'_>], domain: &Domain, findings: &mut Findings) {
    let points: Vec<[f64; 3]> = bodies.iter().map(|body| body.sphere.position).collect();
    let widths: Vec<f64> = bodies.iter().map(|body| body.sphere.diameter).collect();
    let boxes = Boxes::new(domain, &points, &widths);
    for (k, body) in bodies.iter().enumerate() {
        if let Some(other) = boxes.first_before(k, |j| overlap(&bodies[j], body, domain)) {
            let message = format!("this sphere overlaps {}", bodies[other].at);
            let help = "move one of the two, or make it smaller";
            findings.problem_with_help(&body.at, message, help);
        }
    }
}

fn overlap(a: &Placed<'_>, b: &Placed<'_>, domain: &Domain) -> bool {
    let joined = a.clump.is_some() && a.clump == b.clump;
    if joined || !a.free && !b.free {
        return false;
    }
    let size = domain.size();
    let squared: f64 = (0..3)
        .map(|axis| {
            let d = a.sphere.position[axis] - b.sphere.position[axis];
            let wraps =
                if domain.is_periodic(axis) { (d / size[axis]).round() * size[axis] } else { 0.0 };
            (d - wraps).powi(2)
        })
        .sum();
    let tolerance = TOLERANCE * a.sphere.diameter.min(b.sphere.diameter);
    squared.sqrt() < 0.5 * (a.sphere.diameter + b.sphere.diameter) - tolerance
}
