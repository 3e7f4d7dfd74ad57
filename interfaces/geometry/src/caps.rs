//! Triangles with hardly any height.
//!
//! A mesher that puts a vertex on the edge of a flat side may close the surface with a triangle
//! whose three corners are in line. It has no normal worth the name, and its edges seem to bend.
//! Exchanging its longest edge for the other diagonal of the quadrilateral with the neighbour there
//! removes it; the surface moves by less than the triangle's height.

use crate::edges::{ends, pair};
use crate::{Mesh, Vec3};
use std::collections::BTreeSet;

/// Exchanges the longest edges of triangles lower than `least` [m], where that makes the lower of
/// both triangles higher. Returns how many were exchanged.
pub fn flip_caps(mesh: &mut Mesh, least: f64) -> usize {
    let is_cap = |mesh: &Mesh, t: u32| height(&mesh.corners(t as usize)).0 < least;
    let caps = (0..mesh.triangles.len() as u32).rev().filter(|&t| is_cap(mesh, t));
    let mut caps: Vec<u32> = caps.collect();
    if caps.is_empty() {
        return 0;
    }
    let mut flips = Flips::of(mesh);
    let mut flipped = 0;
    // Each exchange makes the lower triangle of a pair higher, so none comes back; rounding might,
    // hence the limit.
    let limit = 16 * caps.len();
    while let Some(cap) = caps.pop() {
        if flipped == limit || !is_cap(flips.mesh, cap) {
            continue;
        }
        let longest = height(&flips.mesh.corners(cap as usize)).1;
        if let Some(around) = flips.flip(3 * cap + longest) {
            flipped += 1;
            caps.extend(around);
        }
    }
    flipped
}

/// Height of a triangle over its longest edge, and which that is.
fn height(corners: &[Vec3; 3]) -> (f64, u32) {
    let square = |i: usize| (corners[i] - corners[(i + 1) % 3]).norm_squared();
    let longest = (0..3).fold(0, |best, i| if square(i) > square(best) { i } else { best });
    let [a, b, c] = *corners;
    ((b - a).cross(&(c - a)).norm() / square(longest).sqrt(), longest as u32)
}

/// A mesh whose edges are being exchanged.
struct Flips<'a> {
    mesh: &'a mut Mesh,
    twins: Vec<u32>,
    /// Ends of the edges that the mesh had at first, the lower first; sorted.
    edges: Vec<[u32; 2]>,
    /// And of those it got.
    added: BTreeSet<[u32; 2]>,
}

impl<'a> Flips<'a> {
    fn of(mesh: &'a mut Mesh) -> Self {
        let twins = pair(&mesh.triangles).twins;
        let mut edges: Vec<[u32; 2]> = (0..twins.len() as u32)
            .map(|h| ends(&mesh.triangles, h))
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        Self { mesh, twins, edges, added: BTreeSet::new() }
    }

    /// Exchanges the edge of a half-edge for the other diagonal, if that helps, and names both
    /// triangles and those around, for which it may help now.
    fn flip(&mut self, half_edge: u32) -> Option<[u32; 6]> {
        let twin = self.twins[half_edge as usize];
        let (one, other) = (half_edge / 3, twin / 3);
        let next = |h: u32| h / 3 * 3 + (h + 1) % 3;
        // From a to b, on to c and back; from b to a, on to d and back.
        let [a, b] = ends(&self.mesh.triangles, half_edge);
        let c = ends(&self.mesh.triangles, next(half_edge))[1];
        let d = ends(&self.mesh.triangles, next(twin))[1];
        let diagonal = [c.min(d), c.max(d)];
        let exists = self.edges.binary_search(&diagonal).is_ok() || self.added.contains(&diagonal);
        let exchanged = ([c, a, d], [d, b, c]);
        if c == d || exists || self.lower(exchanged) <= self.lower(([a, b, c], [b, a, d])) {
            return None;
        }
        let outer = [next(next(half_edge)), next(twin), next(next(twin)), next(half_edge)];
        let outer = outer.map(|h| self.twins[h as usize]);
        self.mesh.triangles[one as usize] = exchanged.0;
        self.mesh.triangles[other as usize] = exchanged.1;
        let (i, j) = (3 * one, 3 * other);
        for (h, g) in [i, i + 1, j, j + 1].into_iter().zip(outer).chain([(i + 2, j + 2)]) {
            self.twins[h as usize] = g;
            self.twins[g as usize] = h;
        }
        self.added.insert(diagonal);
        let [p, q, r, s] = outer.map(|h| h / 3);
        Some([p, q, r, s, one, other])
    }

    /// The height of the lower of two triangles.
    fn lower(&self, (x, y): ([u32; 3], [u32; 3])) -> f64 {
        let height = |t: [u32; 3]| height(&t.map(|v| self.mesh.vertices[v as usize])).0;
        height(x).min(height(y))
    }
}
