//! Cuts at symmetry planes: the eye looks into what the run computes.

use std::collections::BTreeMap;
use tremie_geometry::{Mesh, Vec3};
use tremie_messages::scene::{Domain, Face, Motion, Part};

/// A symmetry plane: the part of space on its inner side is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    axis: usize,
    at: f64,
    /// 1 where what is kept has the larger coordinates, else -1.
    inward: f64,
    /// Distances below this are none [m].
    tolerance: f64,
}

impl Mirror {
    /// Those of a domain.
    pub fn all(domain: &Domain) -> Vec<Self> {
        let size = domain.size();
        let tolerance = 1e-7 * size.into_iter().fold(0.0, f64::max);
        let mirror = |axis: usize, side: usize| {
            let (at, inward) = [(domain.min[axis], 1.0), (domain.max[axis], -1.0)][side];
            let is_mirror = domain.faces[axis][side] == Face::Symmetry;
            is_mirror.then_some(Self { axis, at, inward, tolerance })
        };
        (0..3).flat_map(|axis| [mirror(axis, 0), mirror(axis, 1)]).flatten().collect()
    }

    /// Those of `all` that a part keeps its place to, however it moves.
    pub fn of(all: &[Self], part: &Part) -> Vec<Self> {
        let stays = |mirror: &&Self| match &part.motion {
            Motion::Fixed => true,
            Motion::Slider(slider) => slider.axis[mirror.axis].abs() < 1e-9,
            Motion::Free | Motion::Prescribed(_) | Motion::Timed(_) => false,
        };
        all.iter().filter(stays).copied().collect()
    }

    /// Direction out of the domain: axis and sign.
    pub fn outward(&self) -> (usize, f64) {
        (self.axis, -self.inward)
    }

    /// Distance of a point from it, positive inside [m].
    pub fn distance(&self, point: Vec3) -> f64 {
        let distance = self.inward * (point[self.axis] - self.at);
        if distance.abs() < self.tolerance { 0.0 } else { distance }
    }

    /// The part of `mesh`, in the world, that is inside; with `caps`, what a solid shows where it
    /// is cut.
    pub fn cut(&self, mesh: &Mesh, caps: bool) -> Mesh {
        let mut cut =
            MeshCut { mirror: *self, mesh, out: mesh.clone(), crossings: BTreeMap::new() };
        cut.out.triangles.clear();
        let mut edges = Vec::new();
        for triangle in &mesh.triangles {
            edges.extend(cut.triangle(*triangle));
        }
        let mut out = cut.out;
        if caps {
            self.cap(&edges, &mut out);
        }
        out
    }

    /// Fills the area that `edges` enclose, cut into trapezoids: any number of outlines, holes too.
    fn cap(&self, edges: &[[u32; 2]], out: &mut Mesh) {
        let (a, b) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let flat = |vertex: u32| {
            let place = out.vertices[vertex as usize];
            [place[a], place[b]]
        };
        let segments: Vec<_> = edges.iter().map(|edge| edge.map(flat)).collect();
        let mut heights: Vec<f64> = segments.iter().flatten().map(|point| point[1]).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|next, before| *next - *before < self.tolerance);
        for slab in heights.windows(2) {
            self.fill_slab(&segments, [slab[0], slab[1]], out);
        }
    }

    fn fill_slab(&self, segments: &[[[f64; 2]; 2]], [low, high]: [f64; 2], out: &mut Mesh) {
        let middle = 0.5 * (low + high);
        let crosses = |[p, q]: &&[[f64; 2]; 2]| (p[1] < middle) != (q[1] < middle);
        let at = |[p, q]: [[f64; 2]; 2], height: f64| {
            let share = ((height - p[1]) / (q[1] - p[1])).clamp(0.0, 1.0);
            p[0] + share * (q[0] - p[0])
        };
        let mut sides: Vec<_> = segments.iter().filter(crosses).collect();
        sides.sort_by(|x, y| at(**x, middle).total_cmp(&at(**y, middle)));
        for pair in sides.chunks_exact(2) {
            let corner = |side: &[[f64; 2]; 2], height: f64| {
                let mut place = Vec3::zeros();
                place[self.axis] = self.at;
                place[(self.axis + 1) % 3] = at(*side, height);
                place[(self.axis + 2) % 3] = height;
                place
            };
            let first = out.vertices.len() as u32;
            out.vertices.extend([
                corner(pair[0], low),
                corner(pair[1], low),
                corner(pair[1], high),
                corner(pair[0], high),
            ]);
            // Anticlockwise seen from outside the domain.
            let faces =
                if self.inward < 0.0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
            out.triangles.extend(faces.map(|corners| corners.map(|k| first + k)));
        }
    }
}

/// A mesh that is being cut.
struct MeshCut<'a> {
    mirror: Mirror,
    mesh: &'a Mesh,
    out: Mesh,
    /// Vertices on the plane, by the edge that they cut.
    crossings: BTreeMap<[u32; 2], u32>,
}

impl MeshCut<'_> {
    fn distance(&self, vertex: u32) -> f64 {
        self.mirror.distance(self.mesh.vertices[vertex as usize])
    }

    /// Keeps what is inside of a triangle; the edge along which it is cut, if it is.
    fn triangle(&mut self, corners: [u32; 3]) -> Option<[u32; 2]> {
        let is_inside = corners.map(|corner| self.distance(corner) >= 0.0);
        if is_inside == [true; 3] {
            self.out.triangles.push(corners);
            return None;
        }
        let (mut kept, mut cut) = (Vec::with_capacity(4), Vec::with_capacity(2));
        for k in 0..3 {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            if is_inside[k] {
                kept.push(from);
            }
            if is_inside[k] != is_inside[(k + 1) % 3] {
                let crossing = self.crossing(from, to);
                kept.push(crossing);
                cut.push(crossing);
            }
        }
        for k in 1..kept.len().saturating_sub(1) {
            let triangle = [kept[0], kept[k], kept[k + 1]];
            if triangle[0] != triangle[1]
                && triangle[1] != triangle[2]
                && triangle[2] != triangle[0]
            {
                self.out.triangles.push(triangle);
            }
        }
        <[u32; 2]>::try_from(cut).ok().filter(|[a, b]| a != b)
    }

    /// The vertex where an edge meets the plane: the end that lies on it, or a new one.
    fn crossing(&mut self, from: u32, to: u32) -> u32 {
        let (a, b) = (from.min(to), from.max(to));
        let (d, e) = (self.distance(a), self.distance(b));
        if d == 0.0 || e == 0.0 {
            return if d == 0.0 { a } else { b };
        }
        let (vertices, mirror) = (&mut self.out.vertices, self.mirror);
        *self.crossings.entry([a, b]).or_insert_with(|| {
            let (p, q) = (self.mesh.vertices[a as usize], self.mesh.vertices[b as usize]);
            let mut place = p + (q - p) * (d / (d - e));
            place[mirror.axis] = mirror.at;
            vertices.push(place);
            vertices.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::Geometry;

    /// Volume that triangles enclose, all anticlockwise seen from outside.
    fn volume(mesh: &Mesh) -> f64 {
        let of = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize]);
            a.dot(&b.cross(&c)) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    fn mirror(axis: usize, at: f64, inward: f64) -> Mirror {
        Mirror { axis, at, inward, tolerance: 1e-9 }
    }

    #[test]
    fn a_solid_that_is_cut_is_closed_again_by_its_cap() {
        let shapes = [
            Geometry::Box { size: [2.0, 1.0, 1.0] },
            Geometry::Cylinder { radius: 0.7, length: 2.0 },
            Geometry::Sphere { radius: 1.0 },
        ];
        for shape in shapes {
            let mesh = Mesh::of(&shape).unwrap();
            let whole = volume(&mesh);
            for axis in 0..3 {
                for inward in [1.0, -1.0] {
                    let half = mirror(axis, 0.0, inward).cut(&mesh, true);
                    assert!(
                        (volume(&half) / whole - 0.5).abs() < 1e-9,
                        "{shape:?} {axis} {inward}"
                    );
                    let (axis, sign) = mirror(axis, 0.0, inward).outward();
                    let used = half.triangles.iter().flatten().map(|k| half.vertices[*k as usize]);
                    assert!(used.into_iter().all(|p| p[axis] * sign < 1e-9));
                }
            }
        }
    }

    #[test]
    fn a_hole_stays_open() {
        // A pipe: a box with a box taken out of it, all along z.
        let outer = Mesh::of(&Geometry::Box { size: [2.0, 2.0, 2.0] }).unwrap();
        let inner = Mesh::of(&Geometry::Box { size: [1.0, 1.0, 1.0] }).unwrap();
        let first = outer.vertices.len() as u32;
        let mut hollow = outer;
        hollow.vertices.extend(&inner.vertices);
        hollow
            .triangles
            .extend(inner.triangles.iter().map(|[a, b, c]| [a + first, c + first, b + first]));
        let half = mirror(0, 0.25, 1.0).cut(&hollow, true);
        assert!((volume(&half) - (0.75 * 4.0 - 0.25)).abs() < 1e-9, "{}", volume(&half));
    }

    #[test]
    fn what_lies_beyond_vanishes_and_what_lies_inside_stays() {
        let mesh = Mesh::of(&Geometry::Sphere { radius: 1.0 }).unwrap();
        assert!(mirror(1, 2.0, 1.0).cut(&mesh, true).triangles.is_empty());
        assert_eq!(mirror(1, 2.0, -1.0).cut(&mesh, true), mesh);
        let shifted = Mesh {
            vertices: mesh
                .vertices
                .iter()
                .map(|p| *p + Vec3::from([0.0, 1.0, 0.0]) * 1.1)
                .collect(),
            ..mesh
        };
        assert_eq!(
            mirror(1, 0.0, 1.0).cut(&shifted, true).triangles.len(),
            shifted.triangles.len()
        );
    }
}
