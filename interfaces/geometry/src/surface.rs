//! A closed surface, ready to be asked.

use crate::edges::{Edges, pair};
use crate::endless::Period;
use crate::features::Features;
use crate::inside::{Winding, winding};
use crate::moments::signed_volume;
use crate::orient::turn_round;
use crate::tree::{Tree, Walk};
use crate::{
    Bounds, EdgeKind, Fault, GeometryError, Loaded, Mesh, Repairs, Vec3, VertexKind, load,
};
use tremie_messages::scene::{Geometry, Part};

/// A closed surface in its part's frame, ready to be asked about points, segments, rows of points,
/// and its triangles nearby.
///
/// The solid is what the surface encloses; for a cavity, what is outside. Normals point out of the
/// solid, into the free space, in both cases, and the surface itself is solid.
///
/// Questions need no lock and, but for the room in the vectors given to them, no memory: threads
/// may share a surface.
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) mesh: Mesh,
    pub(crate) tree: Tree,
    pub(crate) features: Features,
    /// Winding number that the surface is taken to have far away: 1 for a cavity; of an endless
    /// surface that which it is short of.
    pub(crate) far: i32,
    is_cavity: bool,
    bounding_radius: f64,
    repairs: Repairs,
    /// Of an endless one: its period.
    pub(crate) period: Option<Box<Period>>,
}

impl Surface {
    /// The surface of a part, in the part's frame, as if no face were periodic.
    ///
    /// # Errors
    /// As [`load`].
    pub fn of_part(part: &Part) -> Result<Self, GeometryError> {
        let solid = Self::of(&part.geometry)?;
        Ok(if part.cavity { solid.inside_out() } else { solid })
    }

    /// Extent along a unit vector.
    pub fn width_along(&self, direction: [f64; 3]) -> f64 {
        let [x, y, z] = direction;
        let heights = self.mesh().vertices.iter().map(|v| v[0] * x + v[1] * y + v[2] * z);
        let [low, high] =
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], x| [l.min(x), h.max(x)]);
        high - low
    }

    /// The surface of a geometry, repaired as [`load`] does.
    ///
    /// # Errors
    /// As [`load`].
    pub fn of(geometry: &Geometry) -> Result<Self, GeometryError> {
        let Loaded { mesh, repairs } = load(geometry)?;
        Ok(Self { repairs, ..Self::new(mesh)? })
    }

    /// The surface of a mesh that needs no repair: one from [`load`] or [`mend`](crate::mend).
    ///
    /// # Errors
    /// [`GeometryError::Faults`] for a mesh that is not closed, whose triangles wind in opposite
    /// ways or inward; and numbers that are no points.
    pub fn new(mesh: Mesh) -> Result<Self, GeometryError> {
        mesh.check_numbers()?;
        if mesh.triangles.is_empty() {
            return Err(GeometryError::Empty { found: 0 });
        }
        let edges = pair(&mesh.triangles);
        let mut faults = edges.faults(&mesh, 0.0);
        faults.extend(edges.winding_fault(&mesh));
        let bounds = mesh.bounds();
        let corners = (0..mesh.triangles.len()).map(|t| mesh.corners(t));
        if faults.is_empty() && signed_volume(corners, bounds.centre()) <= 0.0 {
            faults.push(Fault::Inward { triangles: mesh.triangles.len(), bounds });
        }
        if !faults.is_empty() {
            return Err(GeometryError::Faults(faults));
        }
        Ok(Self::assembled(mesh, edges, 0))
    }

    /// An endless surface from its triangles in the part's frame; `whole` is that of the part as it
    /// was drawn.
    pub(crate) fn of_period(
        mesh: Mesh,
        period: Period,
        whole: &Self,
    ) -> Result<Self, GeometryError> {
        mesh.check_numbers()?;
        let mut edges = pair(&mesh.triangles);
        edges.pair_crowded(&mesh.triangles);
        let radius = period.radius;
        let mut own = Self::assembled(mesh, edges, 0);
        own.period = Some(Box::new(period));
        own.bounding_radius = radius;
        own.repairs = whole.repairs;
        Ok(own)
    }

    /// Its winding number around a point; none on the surface itself.
    pub(crate) fn winding_number(&self, point: Vec3) -> Option<i32> {
        match winding(&self.tree, point) {
            Winding::On => None,
            Winding::Off(number) => Some(number + self.far),
        }
    }

    /// The same surface around the rest of space: what was solid is free, what was free is solid,
    /// and all triangles are turned round.
    pub fn inside_out(mut self) -> Self {
        self.mesh.triangles.iter_mut().for_each(turn_round);
        let edges = pair(&self.mesh.triangles);
        let mut edges = edges;
        edges.pair_crowded(&self.mesh.triangles);
        let mut own = Self::assembled(self.mesh, edges, 1 - self.far);
        if let Some(mut period) = self.period {
            period.volume = -period.volume;
            own.bounding_radius = period.radius;
            own.period = Some(period);
        }
        Self { repairs: self.repairs, is_cavity: !self.is_cavity, ..own }
    }

    /// Moves the vertices of the mesh; its triangles stay. Costs a small part of building the
    /// surface anew, and answers are those of one that was, as long as triangles stay near their
    /// neighbours.
    ///
    /// # Panics
    /// If there are not as many as the mesh has.
    pub fn reshape<P: Into<Vec3> + Copy>(&mut self, vertices: &[P]) {
        assert_eq!(self.mesh.vertices.len(), vertices.len(), "a place for each vertex");
        for (own, place) in self.mesh.vertices.iter_mut().zip(vertices) {
            *own = (*place).into();
        }
        self.tree.refit(|triangle| self.mesh.corners(triangle));
        self.features.refit(&self.mesh);
        self.bounding_radius = self.mesh.bounding_radius();
    }

    fn assembled(mesh: Mesh, edges: Edges, far: i32) -> Self {
        let tree = Tree::of((0..mesh.triangles.len()).map(|t| mesh.corners(t)));
        let features = Features::of(&mesh, edges.twins);
        let bounding_radius = mesh.bounding_radius();
        let repairs = Repairs::default();
        Self { mesh, tree, features, far, bounding_radius, repairs, is_cavity: false, period: None }
    }

    /// True if a triangle is a wall: one that closes an endless surface far away is none.
    #[inline]
    pub fn is_wall(&self, triangle: u32) -> bool {
        self.period.as_ref().is_none_or(|period| triangle < period.walls)
    }

    /// Volume that it encloses [m³] and the centre of that; of an endless one those of one period
    /// of the domain.
    pub fn volume_and_centroid(&self) -> (f64, Vec3) {
        match &self.period {
            Some(period) => (period.volume, period.centroid),
            None => {
                let moments = self.mesh.moments();
                (moments.volume, moments.centroid)
            }
        }
    }

    /// Area of its walls [m²]; of an endless one that of one period of the domain.
    pub fn area(&self) -> f64 {
        let walls = (0..self.mesh.triangles.len()).filter(|&t| self.is_wall(t as u32));
        let areas = walls.map(|t| {
            let [a, b, c] = self.mesh.corners(t);
            0.5 * (b - a).cross(&(c - a)).norm()
        });
        areas.sum::<f64>() / self.period.as_ref().map_or(1.0, |period| period.copies)
    }

    /// True if the space outside is solid, and that inside free.
    pub fn is_cavity(&self) -> bool {
        self.is_cavity
    }

    /// Its triangles. Those of a cavity face inward: its volume is negative.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Repairs of its mesh when that was loaded.
    pub fn repairs(&self) -> &Repairs {
        &self.repairs
    }

    /// The least box around it, in the part's frame.
    pub fn bounds(&self) -> Bounds {
        self.tree.bounds()
    }

    /// Distance of its farthest point from the origin of the part's frame [m]; of an endless one
    /// across its axes.
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// Puts into `out` the walls whose boxes meet a box, ascending. Allocates only where `out`
    /// has to grow.
    pub fn triangles_near(&self, bounds: &Bounds, out: &mut Vec<u32>) {
        out.clear();
        self.tree.walk(
            |b| b.meets(bounds),
            |triangle, corners| {
                if self.is_wall(triangle) && Bounds::of(*corners).meets(bounds) {
                    out.push(triangle);
                }
                Walk::On
            },
        );
        out.sort_unstable();
    }

    /// Outward unit normal of a triangle; zero for one without area.
    pub fn normal(&self, triangle: u32) -> Vec3 {
        self.features.normal(triangle)
    }

    /// Triangles across the three edges of a triangle; edge `i` runs from corner `i` to the next.
    pub fn neighbours(&self, triangle: u32) -> [u32; 3] {
        self.features.neighbours(triangle)
    }

    /// Bend of the surface at the three edges of a triangle.
    pub fn edge_kinds(&self, triangle: u32) -> [EdgeKind; 3] {
        self.features.edge_kinds(triangle)
    }

    /// Kind of a vertex of the mesh.
    pub fn vertex_kind(&self, vertex: u32) -> VertexKind {
        self.features.vertex_kind(vertex)
    }
}
