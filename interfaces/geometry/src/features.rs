//! Normals, neighbours, and which edges and corners are real.
//!
//! A flat wall made of triangles has edges and corners that are none. A grain that rolls over them
//! must not feel a bump: contacts with an edge or a vertex count only if it is a real one, and not
//! in the plane of a face contact.

use crate::edges::ends;
use crate::exact::below;
use crate::vector::unit;
use crate::{Mesh, Vec3};

/// Two triangles whose normals differ by less than this angle [rad] are taken for one plane, and
/// two edges for one line. Vertices in single precision make angles of 1e-4 between triangles that
/// are a thousandth of the part; the sides of a cylinder of 256 meet at 2.5e-2.
pub const FLAT_ANGLE: f64 = 1e-3;

/// Bend of the surface at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// It sticks out: something outside can touch the edge alone.
    Convex,
    /// It does not, within [`FLAT_ANGLE`].
    Flat,
    /// It is a groove: whatever touches the edge touches both sides.
    Concave,
}

/// Kind of a vertex: whether the surface bends there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// A point of a plane: all its edges are flat.
    Flat,
    /// A point of a straight edge: two of its edges are not flat, bend the same way and are in
    /// line.
    Ridge,
    /// A corner.
    Corner,
}

/// Normals, neighbours and bends of triangles, edges and vertices.
#[derive(Clone, Debug)]
pub struct Features {
    twins: Vec<u32>,
    normals: Vec<Vec3>,
    vertex_normals: Vec<Vec3>,
    edges: Vec<EdgeKind>,
    vertices: Vec<VertexKind>,
}

impl Features {
    /// The features of a closed mesh whose half-edges are paired.
    pub fn of(mesh: &Mesh, twins: Vec<u32>) -> Self {
        let normal = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            unit((b - a).cross(&(c - a))).unwrap_or(Vec3::zeros())
        };
        let normals: Vec<Vec3> = (0..mesh.triangles.len()).map(normal).collect();
        let vertex_normals = vertex_normals(mesh, &normals);
        let edges: Vec<EdgeKind> =
            (0..twins.len() as u32).map(|h| edge_kind(mesh, &normals, h, &twins)).collect();
        let vertices = vertex_kinds(mesh, &edges, &twins);
        Self { twins, normals, vertex_normals, edges, vertices }
    }

    /// The features of the same mesh with its vertices elsewhere.
    pub fn refit(&mut self, mesh: &Mesh) {
        *self = Self::of(mesh, std::mem::take(&mut self.twins));
    }

    pub fn normal(&self, triangle: u32) -> Vec3 {
        self.normals[triangle as usize]
    }

    pub fn neighbours(&self, triangle: u32) -> [u32; 3] {
        [0, 1, 2].map(|i| self.twins[3 * triangle as usize + i] / 3)
    }

    pub fn edge_kinds(&self, triangle: u32) -> [EdgeKind; 3] {
        [0, 1, 2].map(|i| self.edges[3 * triangle as usize + i])
    }

    pub fn vertex_kind(&self, vertex: u32) -> VertexKind {
        self.vertices[vertex as usize]
    }

    /// The mean of the normals on both sides of an edge. Where they cancel, on a knife's edge, that
    /// of this side.
    pub fn edge_normal(&self, triangle: u32, i: u8) -> Vec3 {
        let here = self.normal(triangle);
        let there = self.normal(self.neighbours(triangle)[i as usize]);
        unit(here + there).unwrap_or(here)
    }

    pub fn vertex_normal(&self, vertex: u32) -> Vec3 {
        self.vertex_normals[vertex as usize]
    }
}

/// Means of the normals around each vertex, weighted by the triangles' angles there.
fn vertex_normals(mesh: &Mesh, normals: &[Vec3]) -> Vec<Vec3> {
    let mut sums = vec![Vec3::zeros(); mesh.vertices.len()];
    for (t, names) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(t);
        for i in 0..3 {
            let (u, v) = (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
            let angle = libm::atan2(u.cross(&v).norm(), u.dot(&v));
            sums[names[i] as usize] += normals[t] * angle;
        }
    }
    sums.into_iter().map(|sum| unit(sum).unwrap_or(Vec3::zeros())).collect()
}

/// Bend of the surface at a half-edge. Both halves of an edge get the same answer.
fn edge_kind(mesh: &Mesh, normals: &[Vec3], half_edge: u32, twins: &[u32]) -> EdgeKind {
    let twin = twins[half_edge as usize];
    let (first, second) = (half_edge.min(twin), half_edge.max(twin));
    let (one, other) = (first as usize / 3, second as usize / 3);
    let (n, m) = (normals[one], normals[other]);
    let sine = n.cross(&m).norm();
    if n.dot(&m) >= 0.0 && sine < FLAT_ANGLE {
        return EdgeKind::Flat;
    }
    let opposite = mesh.corners(other)[(second as usize + 2) % 3];
    if below(&mesh.corners(one), opposite) >= 0.0 { EdgeKind::Convex } else { EdgeKind::Concave }
}

/// Looks at the edges around each vertex that are not flat.
fn vertex_kinds(mesh: &Mesh, edges: &[EdgeKind], twins: &[u32]) -> Vec<VertexKind> {
    #[derive(Clone, Copy, Default)]
    struct Bends {
        count: u32,
        kinds: [Option<EdgeKind>; 2],
        ends: [u32; 2],
    }
    let mut around = vec![Bends::default(); mesh.vertices.len()];
    for h in 0..twins.len() {
        if edges[h] == EdgeKind::Flat || twins[h] < h as u32 {
            continue;
        }
        let [a, b] = ends(&mesh.triangles, h as u32);
        for (at, end) in [(a, b), (b, a)] {
            let bends = &mut around[at as usize];
            if let Some(kind) = bends.kinds.get_mut(bends.count as usize) {
                *kind = Some(edges[h]);
                bends.ends[bends.count as usize] = end;
            }
            bends.count += 1;
        }
    }
    let place = |v: u32| mesh.vertices[v as usize];
    let kind = |(vertex, bends): (usize, Bends)| match bends.count {
        0 => VertexKind::Flat,
        2 if bends.kinds[0] == bends.kinds[1] => {
            let here = mesh.vertices[vertex];
            let to = bends.ends.map(|end| unit(place(end) - here).unwrap_or(Vec3::zeros()));
            let straight = to[0].dot(&to[1]) < 0.0 && to[0].cross(&to[1]).norm() < FLAT_ANGLE;
            if straight { VertexKind::Ridge } else { VertexKind::Corner }
        }
        _ => VertexKind::Corner,
    };
    around.into_iter().enumerate().map(kind).collect()
}
