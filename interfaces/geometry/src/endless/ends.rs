//! Closes a row of periods far beyond the domain.
//!
//! Winding numbers need a closed surface. How it is closed does not matter where it is asked about,
//! as long as that happens elsewhere: two ways to close it differ by a closed surface beyond the
//! domain, which goes equally often around all points in it. So the open edges at each end go to
//! one point beyond that end, axis by axis; what that leaves open between two such points cancels,
//! as there are as many ways into the part as out of it along the edge of a period.

use super::EndlessFault;
use super::patch::Patch;
use crate::{Bounds, Mesh};
use tremie_messages::scene::Domain;

/// The mesh of `walls`, which are the triangles of the patch, and after them those that close it.
pub fn closed(
    mut patch: Patch,
    walls: Vec<[u32; 3]>,
    axes: [bool; 3],
    domain: &Domain,
) -> Result<Mesh, EndlessFault> {
    let used = walls.iter().flatten().map(|&v| patch.vertices[v as usize]);
    let bounds = Bounds::of(used);
    let away = bounds.size().sup(&domain.size().into()).max().max(0.0);
    patch.faces = walls.iter().map(|t| t.to_vec()).collect();
    let first_apex = patch.vertices.len() as u32;
    for axis in (0..3).filter(|&a| axes[a]) {
        let period = domain.max[axis] - domain.min[axis];
        let ends = [(domain.min[axis] - period, -away), (domain.max[axis] + period, away)];
        for (at, beyond) in ends {
            let is_apex = |v: u32| v >= first_apex;
            // Sums like these name the ends exactly when walls are drawn there; copies may be a
            // hair off.
            let near = 1e-9 * period;
            let on = |v: u32| (patch.vertices[v as usize][axis] - at).abs() <= near;
            let belongs = |&[a, b]: &[u32; 2]| {
                (is_apex(a) || on(a)) && (is_apex(b) || on(b)) && !(is_apex(a) && is_apex(b))
            };
            let open: Vec<[u32; 2]> = patch.open_edges().into_iter().filter(belongs).collect();
            let mut apex = bounds.centre();
            apex[axis] = at + beyond;
            let number = patch.vertices.len() as u32;
            patch.vertices.push(apex);
            patch.faces.extend(open.into_iter().map(|[a, b]| vec![b, a, number]));
        }
    }
    if let Some([a, _]) = patch.open_edges().first() {
        return Err(EndlessFault::Touching { at: patch.vertices[*a as usize] });
    }
    Ok(compact(patch))
}

/// Without the vertices that no face has.
fn compact(patch: Patch) -> Mesh {
    let mut named = vec![u32::MAX; patch.vertices.len()];
    let mut vertices = Vec::new();
    let mut triangles = Vec::with_capacity(patch.faces.len());
    for face in &patch.faces {
        triangles.push([0, 1, 2].map(|k| {
            let old = face[k] as usize;
            if named[old] == u32::MAX {
                named[old] = vertices.len() as u32;
                vertices.push(patch.vertices[old]);
            }
            named[old]
        }));
    }
    Mesh { vertices, triangles }
}
