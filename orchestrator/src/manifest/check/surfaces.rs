//! Checks of the surfaces of parts: whether each is closed, where it is, how large.

use super::super::path;
use super::super::read::Findings;
use super::{extent, point};
use tremie_geometry::{Bounds, GeometryError, Mesh};
use tremie_messages::Problem;
use tremie_messages::finding::short;
use tremie_messages::scene::{Domain, Geometry, Motion, Part};

/// A file's part that is this many times as long as the domain was hardly drawn in the unit given.
const HUGE: f64 = 20.0;
/// The same, of one that is this part of the domain's length.
const TINY: f64 = 1e-3;

/// Notes each part whose surface cannot be read or has holes, whose size does not go with the
/// domain, or that is not in it.
pub(super) fn check(domain: &Domain, parts: &[Option<Part>], findings: &mut Findings) {
    for (i, part) in parts.iter().enumerate() {
        let Some(part) = part else { continue };
        let at = path::item("scene.parts", i);
        let is_file = matches!(part.geometry, Geometry::File { .. });
        let key = if is_file { path::join(&at, "file") } else { at.clone() };
        match Mesh::of(&part.geometry) {
            Ok(mesh) => {
                let bounds = mesh.placed(&part.pose).bounds();
                if is_file && !fits(&bounds, domain, &at, findings) {
                    continue;
                }
                inside(part, &bounds, domain, &at, findings);
            }
            Err(error) => {
                let explained = error.problems(&key).into_iter().map(|p| explain(p, &error));
                explained.for_each(|problem| findings.add(problem));
            }
        }
    }
}

/// Adds the folder that a path is relative to, or the frame of places, to a problem with a part's
/// file.
fn explain(mut problem: Problem, error: &GeometryError) -> Problem {
    match error {
        GeometryError::Read { .. } => {
            problem.help("a relative path begins at the manifest's folder")
        }
        GeometryError::Format { .. } => {
            problem.help("export the part as STL (binary or text) or OBJ, and name it .stl or .obj")
        }
        GeometryError::Faults(_) => {
            problem.message += "; places are those of the part's own frame";
            problem
        }
        _ => problem,
    }
}

/// True if a part has a size that goes with the domain's.
fn fits(bounds: &Bounds, domain: &Domain, at: &str, findings: &mut Findings) -> bool {
    let longest = |size: [f64; 3]| size.into_iter().fold(0.0, f64::max);
    let (part, whole) = (longest(bounds.size().into()), longest(domain.size()));
    let right = part <= HUGE * whole && part >= TINY * whole;
    if !right {
        let message = format!(
            "the part is {} m long, in a domain of {} m: is its unit right?",
            short(part),
            short(whole)
        );
        findings.add(
            Problem::new(path::join(at, "unit"), message).help(
                "the unit is what the number 1 in the file means, as \"mm\" for most drawings",
            ),
        );
    }
    right
}

/// Notes a part that has nothing in the domain, unless it may come there.
fn inside(part: &Part, bounds: &Bounds, domain: &Domain, at: &str, findings: &mut Findings) {
    let moves = part.motion != Motion::Fixed;
    if moves || bounds.meets(&Bounds::of([domain.min, domain.max])) {
        return;
    }
    let message = format!(
        "the part reaches from {} m to {} m, wholly outside the domain, which is {}",
        point(&bounds.min.into()),
        point(&bounds.max.into()),
        extent(domain)
    );
    // A file may be drawn far from its origin, which is what a position moves.
    let middle = bounds.centre();
    let there =
        |k: usize| part.pose.position[k] + 0.5 * (domain.min[k] + domain.max[k]) - middle[k];
    let help = format!(
        "give it a position, or check its unit; position = [\"{:.6} m\", \"{:.6} m\", \"{:.6} m\"] brings its middle to \
         that of the domain",
        there(0),
        there(1),
        there(2)
    );
    findings.problem_with_help(at, message, help);
}
