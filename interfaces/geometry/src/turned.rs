//! Sections that turn about an axis: surfaces whose vertices move and whose triangles stay.

use crate::Vec3;
use std::f64::consts::PI;
use tremie_messages::scene::{DeformableSurface, FacetKind, Section};

/// The surface that a section sweeps when it turns about the z axis, in steps: triangles with fixed
/// vertices, whose places follow from the section's points.
///
/// Circles become polygons with the same area, as those of parts do.
#[derive(Clone, Debug, PartialEq)]
pub struct Turned {
    /// Vertices of each triangle, anticlockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Kind of each triangle, in the order of the section's edges.
    pub kinds: Vec<FacetKind>,
    /// Point of the section behind each vertex.
    pub section: Vec<u32>,
    /// Cosine and sine of each vertex's angle about the axis, times the polygon's stretch.
    turns: Vec<[f64; 2]>,
}

impl Turned {
    /// Turns `section` in `sectors` steps, at least 3.
    ///
    /// Vertices are numbered by point, in the order in which the edges name the points, and by
    /// angle from the x axis; triangles by edge and angle.
    ///
    /// # Panics
    /// If an edge names a point that is not there.
    pub fn new(section: &Section, sectors: usize) -> Self {
        let mut circles = Circles::new(section, sectors.max(3));
        section.edges.iter().flat_map(|edge| edge.points).for_each(|point| circles.add(point));
        let (mut triangles, mut kinds) = (Vec::new(), Vec::new());
        for edge in &section.edges {
            circles.join(edge.points, &mut triangles);
            kinds.resize(triangles.len(), edge.kind);
        }
        Self { triangles, kinds, section: circles.section, turns: circles.turns }
    }

    /// The surface of a scene.
    ///
    /// # Panics
    /// If its section has an edge that names a point which is not there.
    pub fn of(surface: &DeformableSurface) -> Self {
        Self::new(&surface.section, surface.sectors as usize)
    }

    /// Cosine and sine of a vertex's angle about the axis, times the polygon's stretch: its place
    /// is `[r cos, r sin, z]`.
    ///
    /// # Panics
    /// If there is no vertex of that number.
    pub fn turn(&self, vertex: usize) -> [f64; 2] {
        self.turns[vertex]
    }

    /// Number of its vertices.
    pub fn vertex_count(&self) -> usize {
        self.section.len()
    }

    /// Writes the places of all vertices [m] into `out`, for the section's `points` `[r, z]`.
    pub fn place_into(&self, points: &[[f64; 2]], out: &mut [Vec3]) {
        for (vertex, out) in out.iter_mut().enumerate().take(self.section.len()) {
            *out = self.place(points, vertex);
        }
    }

    /// The place of a vertex [m], for the section's `points`.
    ///
    /// # Panics
    /// If there is no vertex of that number, or no point behind it.
    pub fn place(&self, points: &[[f64; 2]], vertex: usize) -> Vec3 {
        let [r, z] = points[self.section[vertex] as usize];
        let [cos, sin] = self.turn(vertex);
        Vec3::new(r * cos, r * sin, z)
    }

    /// Places of all vertices [m], for the section's `points`.
    pub fn places(&self, points: &[[f64; 2]]) -> Vec<Vec3> {
        let mut out = vec![Vec3::zeros(); self.section.len()];
        self.place_into(points, &mut out);
        out
    }
}

/// Numbers of the vertices: on each circle as many as sectors, on the axis one.
struct Circles {
    sectors: usize,
    /// First vertex of each of the section's points; `usize::MAX` of those that no edge has named
    /// yet.
    first: Vec<usize>,
    on_axis: Vec<bool>,
    section: Vec<u32>,
    turns: Vec<[f64; 2]>,
}

impl Circles {
    fn new(section: &Section, sectors: usize) -> Self {
        let on_axis = section.points.iter().map(|point| point[0] == 0.0).collect();
        let first = vec![usize::MAX; section.points.len()];
        Self { sectors, first, on_axis, section: Vec::new(), turns: Vec::new() }
    }

    fn add(&mut self, point: u32) {
        let at = point as usize;
        if self.first[at] != usize::MAX {
            return;
        }
        self.first[at] = self.section.len();
        let step = 2.0 * PI / self.sectors as f64;
        let stretch = (step / libm::sin(step)).sqrt();
        for k in 0..if self.on_axis[at] { 1 } else { self.sectors } {
            let (sin, cos) = libm::sincos(step * k as f64);
            self.section.push(point);
            self.turns.push([stretch * cos, stretch * sin]);
        }
    }

    fn join(&self, [a, b]: [u32; 2], out: &mut Vec<[u32; 3]>) {
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

    fn at(&self, point: u32, k: usize) -> u32 {
        let turn = if self.on_axis[point as usize] { 0 } else { k % self.sectors };
        (self.first[point as usize] + turn) as u32
    }
}
