//! Triangles with hardly any height.
//!
//! A mesher that puts a vertex on the edge of a flat side may close the surface with a triangle whose three
//! corners are in line. It has no normal worth the name, and its edges seem to bend. Exchanging its
//! longest edge for the other diagonal of the quadrilateral with the neighbour there removes it; the
//! surface moves by less than the triangle's height.

use crate::edges::{Edges, ends, pair};
use crate::vector::{cross, distance_squared, norm, sub};
use crate::{Mesh, Vec3};
use std::collections::BTreeSet;

/// Exchanges the longest edges of triangles lower than `least` [m], where that makes both triangles
/// higher. Returns how many were exchanged.
pub fn flip_caps(mesh: &mut Mesh, least: f64) -> usize {
    // Each round takes caps that share no triangle. Rows of caps take several.
    const ROUNDS: usize = 16;
    let mut flipped = 0;
    for _ in 0..ROUNDS {
        let caps: Vec<u32> = (0..mesh.triangles.len())
            .filter(|&t| height(&mesh.corners(t)).0 < least)
            .map(|t| 3 * t as u32 + height(&mesh.corners(t)).1)
            .collect();
        if caps.is_empty() {
            break;
        }
        let edges = pair(&mesh.triangles);
        let mut present = Present::of(mesh);
        let mut touched = vec![false; mesh.triangles.len()];
        let before = flipped;
        for half_edge in caps {
            flipped += usize::from(flip(mesh, half_edge, &edges, &mut present, &mut touched));
        }
        if flipped == before {
            break;
        }
    }
    flipped
}

/// Height of a triangle over its longest edge, and which that is.
fn height(corners: &[Vec3; 3]) -> (f64, u32) {
    let square = |i: usize| distance_squared(corners[i], corners[(i + 1) % 3]);
    let longest = (0..3).fold(0, |best, i| if square(i) > square(best) { i } else { best });
    let [a, b, c] = *corners;
    (norm(cross(sub(b, a), sub(c, a))) / square(longest).sqrt(), longest as u32)
}

/// Exchanges the edge of a half-edge for the other diagonal, if that helps.
fn flip(
    mesh: &mut Mesh,
    half_edge: u32,
    edges: &Edges,
    present: &mut Present,
    touched: &mut [bool],
) -> bool {
    let twin = edges.twins[half_edge as usize];
    let (one, other) = (half_edge as usize / 3, twin as usize / 3);
    if touched[one] || touched[other] {
        return false;
    }
    let [a, b] = ends(&mesh.triangles, half_edge);
    let c = mesh.triangles[one][(half_edge as usize + 2) % 3];
    let d = mesh.triangles[other][(twin as usize + 2) % 3];
    if c == d || present.has(c, d) {
        return false;
    }
    let place = |names: [u32; 3]| names.map(|v| mesh.vertices[v as usize]);
    let lowest = |x: [u32; 3], y: [u32; 3]| height(&place(x)).0.min(height(&place(y)).0);
    let exchanged = ([c, a, d], [c, d, b]);
    if lowest(exchanged.0, exchanged.1) <= lowest(mesh.triangles[one], mesh.triangles[other]) {
        return false;
    }
    (mesh.triangles[one], mesh.triangles[other]) = exchanged;
    present.added.insert([c.min(d), c.max(d)]);
    touched[one] = true;
    touched[other] = true;
    true
}

/// The edges that a mesh had at the start of a round, and those it got since.
struct Present {
    sorted: Vec<[u32; 2]>,
    added: BTreeSet<[u32; 2]>,
}

impl Present {
    fn of(mesh: &Mesh) -> Self {
        let mut sorted: Vec<[u32; 2]> = (0..3 * mesh.triangles.len() as u32)
            .map(|h| ends(&mesh.triangles, h))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        sorted.sort_unstable();
        Self { sorted, added: BTreeSet::new() }
    }

    fn has(&self, a: u32, b: u32) -> bool {
        let edge = [a.min(b), a.max(b)];
        self.sorted.binary_search(&edge).is_ok() || self.added.contains(&edge)
    }
}
