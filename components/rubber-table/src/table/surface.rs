//! The outline revolved about the axis: a closed surface of triangles, or open where it is cut.

use super::{Facets, Table};
use crate::mesh::Point;

/// What becomes of a piece of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FacetKind {
    /// A: touches the seat in the last frame.
    Seat,
    /// B: stays free.
    Exposed,
    /// Held by steel.
    Bonded,
}

/// The surface of the ring in space, the axis along z. Which vertices a triangle has never changes;
/// where they are follows from the section.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Vertices of each triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// What becomes of each: all of the seat first, then the exposed, then the bonded.
    pub kinds: Vec<FacetKind>,
    /// Vertex of the section behind each vertex.
    pub section: Vec<usize>,
    /// Cosine and sine of each vertex's angle about the axis.
    turns: Vec<[f64; 2]>,
}

impl Table {
    /// Revolves the outline in `sectors` steps, at least 3.
    pub fn surface(&self, sectors: usize) -> Surface {
        let contents = self.contents();
        let on_axis: Vec<bool> = (0..contents.vertices[0].len())
            .map(|vertex| contents.vertices.iter().all(|frame| frame[vertex][0] == 0.0))
            .collect();
        Revolution::new(&contents.facets, &on_axis, sectors.max(3)).surface(&contents.facets)
    }
}

impl Surface {
    /// Writes the places of all vertices [m] for `section`, as from
    /// [`Table::vertices_into`](super::Table::vertices_into), into `out`.
    pub fn place_into(&self, section: &[Point], out: &mut [[f64; 3]]) {
        for ((out, vertex), [cos, sin]) in out.iter_mut().zip(&self.section).zip(&self.turns) {
            let [r, z] = section[*vertex];
            *out = [r * cos, r * sin, z];
        }
    }

    /// Places of all vertices [m] for `section`.
    pub fn places(&self, section: &[Point]) -> Vec<[f64; 3]> {
        let mut out = vec![[0.0; 3]; self.section.len()];
        self.place_into(section, &mut out);
        out
    }
}

/// Numbers of the vertices in space: on each circle as many as sectors, on the axis one.
struct Revolution {
    sectors: usize,
    /// First number of each of the section's vertices; `usize::MAX` of those inside.
    first: Vec<usize>,
    on_axis: Vec<bool>,
    section: Vec<usize>,
    turns: Vec<[f64; 2]>,
}

impl Revolution {
    fn new(facets: &Facets, on_axis: &[bool], sectors: usize) -> Self {
        let (first, on_axis) = (vec![usize::MAX; on_axis.len()], on_axis.to_vec());
        let mut out = Self { sectors, first, on_axis, section: Vec::new(), turns: Vec::new() };
        let edges = facets.seat.iter().chain(&facets.exposed).chain(&facets.bonded);
        for &vertex in edges.flatten() {
            if out.first[vertex] == usize::MAX {
                out.first[vertex] = out.section.len();
                for k in 0..if out.on_axis[vertex] { 1 } else { sectors } {
                    let (sin, cos) =
                        libm::sincos(core::f64::consts::TAU * k as f64 / sectors as f64);
                    out.section.push(vertex);
                    out.turns.push([cos, sin]);
                }
            }
        }
        out
    }

    fn surface(self, facets: &Facets) -> Surface {
        let mut triangles = Vec::new();
        let mut kinds = Vec::new();
        for (kind, edges) in [
            (FacetKind::Seat, &facets.seat),
            (FacetKind::Exposed, &facets.exposed),
            (FacetKind::Bonded, &facets.bonded),
        ] {
            for edge in edges {
                self.revolve(*edge, &mut triangles);
            }
            kinds.resize(triangles.len(), kind);
        }
        Surface { triangles, kinds, section: self.section, turns: self.turns }
    }

    fn revolve(&self, [a, b]: [usize; 2], out: &mut Vec<[u32; 3]>) {
        for k in 0..self.sectors {
            let (a0, a1) = (self.at(a, k), self.at(a, k + 1));
            let (b0, b1) = (self.at(b, k), self.at(b, k + 1));
            if a0 != a1 {
                out.push([a0, a1, b1]);
            }
            if b0 != b1 {
                out.push([a0, b1, b0]);
            }
        }
    }

    fn at(&self, vertex: usize, k: usize) -> u32 {
        let turn = if self.on_axis[vertex] { 0 } else { k % self.sectors };
        (self.first[vertex] + turn) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::super::Contents;
    use super::super::tests::example;
    use super::*;
    use std::collections::BTreeMap;

    fn volume(surface: &Surface, section: &[Point]) -> f64 {
        let places = surface.places(section);
        let part = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
            let cross =
                [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
            (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
        };
        surface.triangles.iter().map(part).sum()
    }

    /// Each edge is passed once in each direction.
    fn is_closed(surface: &Surface) -> bool {
        let mut balance = BTreeMap::new();
        for [a, b, c] in &surface.triangles {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                *balance.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        balance.values().all(|sum| *sum == 0)
    }

    /// A regular polygon has sin(x)/x of its circle's area, x = 2π/sectors.
    fn polygon(sectors: usize) -> f64 {
        let x = core::f64::consts::TAU / sectors as f64;
        libm::sin(x) / x
    }

    #[test]
    fn a_ring_is_closed_outward_and_has_its_volume() {
        let table = Table::new(example()).unwrap();
        for sectors in [3, 12] {
            let surface = table.surface(sectors);
            assert!(is_closed(&surface));
            let exact = core::f64::consts::PI * 3.0 * polygon(sectors);
            assert!((volume(&surface, &example().vertices[0]) / exact - 1.0).abs() < 1e-12);
            let count = |kind| surface.kinds.iter().filter(|k| **k == kind).count();
            assert_eq!(
                [FacetKind::Seat, FacetKind::Exposed, FacetKind::Bonded].map(count),
                [2 * sectors, 4 * sectors, 2 * sectors]
            );
            assert!(surface.kinds.is_sorted());
        }
    }

    #[test]
    fn a_disc_has_single_vertices_on_the_axis() {
        let frame = |c: f64| vec![[0.0, c], [2.0 + c, c], [2.0, 1.0], [0.0, 1.0]];
        let mut contents = Contents { vertices: [0.0, 0.1, 0.3].map(frame).to_vec(), ..example() };
        // The axis is no surface.
        contents.facets.exposed.pop();
        let surface = Table::new(contents.clone()).unwrap().surface(8);
        assert!(is_closed(&surface));
        assert_eq!(surface.section.iter().filter(|vertex| **vertex == 0).count(), 1);
        let exact = core::f64::consts::PI * 4.0 * polygon(8);
        assert!((volume(&surface, &contents.vertices[0]) / exact - 1.0).abs() < 1e-12);
    }
}
