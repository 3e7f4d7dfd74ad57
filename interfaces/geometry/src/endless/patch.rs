//! A piece of a surface: faces that share corners, cut at planes across the axes.

use crate::{Mesh, Vec3};
use std::collections::BTreeMap;

/// Convex faces that share corners, anticlockwise seen from outside; where it was cut it is open.
#[derive(Clone, Debug)]
pub struct Patch {
    pub vertices: Vec<Vec3>,
    /// Corners of each face, three or more.
    pub faces: Vec<Vec<u32>>,
}

impl Patch {
    /// The triangles of a mesh whose vertices are placed by `place`.
    pub fn of(mesh: &Mesh, place: impl Fn(Vec3) -> Vec3) -> Self {
        Self {
            vertices: mesh.vertices.iter().map(|&v| place(v)).collect(),
            faces: mesh.triangles.iter().map(|t| t.to_vec()).collect(),
        }
    }

    /// Leaves what lies on one side of the plane `x_axis = at`: above it for the sign 1, below for
    /// -1. Corners within `tolerance` of the plane are moved into it; faces in it are left out.
    pub fn cut(&mut self, axis: usize, at: f64, sign: f64, tolerance: f64) {
        for vertex in &mut self.vertices {
            if (vertex[axis] - at).abs() <= tolerance {
                vertex[axis] = at;
            }
        }
        let mut crossings = BTreeMap::new();
        let mut kept = Vec::new();
        for face in std::mem::take(&mut self.faces) {
            let height = |v: u32, own: &Self| sign * (own.vertices[v as usize][axis] - at);
            if face.iter().all(|&v| height(v, self) <= 0.0) {
                continue;
            }
            let mut inside = Vec::with_capacity(face.len() + 1);
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                let (here, there) = (height(from, self), height(to, self));
                if here >= 0.0 {
                    inside.push(from);
                }
                if here * there < 0.0 {
                    let edge = [from.min(to), from.max(to)];
                    let new =
                        *crossings.entry(edge).or_insert_with(|| self.crossing(edge, axis, at));
                    inside.push(new);
                }
            }
            if inside.len() > 2 {
                kept.push(inside);
            }
        }
        self.faces = kept;
    }

    /// A new corner where an edge goes through a plane: the same for both of its faces.
    fn crossing(&mut self, [from, to]: [u32; 2], axis: usize, at: f64) -> u32 {
        let (p, q) = (self.vertices[from as usize], self.vertices[to as usize]);
        let s = (at - p[axis]) / (q[axis] - p[axis]);
        let mut new: Vec3 = Vec3::from_fn(|k, _| p[k] + s * (q[k] - p[k]));
        new[axis] = at;
        self.vertices.push(new);
        self.vertices.len() as u32 - 1
    }

    /// True if all faces run along an axis: seen along it each is a line.
    pub fn is_straight(&self, axis: usize, tolerance: f64) -> bool {
        self.triangles().iter().all(|triangle| {
            let corners = triangle.map(|v| {
                let mut corner = self.vertices[v as usize];
                corner[axis] = 0.0;
                corner
            });
            let sides = [0, 1, 2].map(|i| (corners[(i + 1) % 3] - corners[i]).norm());
            let longest = sides.into_iter().fold(0.0, f64::max);
            let twice = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
            twice <= tolerance * longest
        })
    }

    /// Its edges with a face on one side only, in the direction of that face.
    pub fn open_edges(&self) -> Vec<[u32; 2]> {
        let mut count = BTreeMap::new();
        for face in &self.faces {
            for (k, &from) in face.iter().enumerate() {
                let to = face[(k + 1) % face.len()];
                let sign = if from < to { 1 } else { -1 };
                *count.entry([from.min(to), from.max(to)]).or_insert(0) += sign;
            }
        }
        let directed = |(&[a, b], &n): (&[u32; 2], &i32)| {
            let edge = if n > 0 { [a, b] } else { [b, a] };
            std::iter::repeat_n(edge, n.unsigned_abs() as usize)
        };
        count.iter().flat_map(directed).collect()
    }

    /// Its faces as triangles: of those with four corners by the diagonal that leaves the fatter
    /// ones.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let area = |t: [u32; 3]| {
            let [a, b, c] = t.map(|v| self.vertices[v as usize]);
            (b - a).cross(&(c - a)).norm()
        };
        let mut all = Vec::with_capacity(2 * self.faces.len());
        for face in &self.faces {
            let fan = |first: usize| {
                let at = move |k: usize| face[(first + k) % face.len()];
                (2..face.len()).map(move |k| [at(0), at(k - 1), at(k)])
            };
            let least = |first: usize| fan(first).map(area).fold(f64::INFINITY, f64::min);
            let best = (0..face.len()).fold(0, |b, k| if least(k) > least(b) { k } else { b });
            all.extend(fan(best));
        }
        all
    }
}
