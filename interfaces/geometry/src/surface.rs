//! A closed surface, ready to be asked.

use crate::edges::{Edges, pair};
use crate::features::Features;
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
/// Questions need no lock and, but for the room in the vectors given to them, no memory: threads may
/// share a surface.
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) mesh: Mesh,
    pub(crate) tree: Tree,
    pub(crate) features: Features,
    /// How often the surface is taken to go around points far away: 1 for a cavity.
    pub(crate) far: i32,
    bounding_radius: f64,
    repairs: Repairs,
}

impl Surface {
    /// The surface of a part, in the part's frame.
    ///
    /// # Errors
    /// As [`load`].
    pub fn of_part(part: &Part) -> Result<Self, GeometryError> {
        let solid = Self::of(&part.geometry)?;
        Ok(if part.cavity { solid.inside_out() } else { solid })
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
    /// [`GeometryError::Faults`] for a mesh that is not closed, whose triangles wind in opposite ways
    /// or inward; and numbers that are no points.
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

    /// The same surface around the rest of space: what was solid is free, what was free is solid, and
    /// all triangles are turned round.
    pub fn inside_out(mut self) -> Self {
        self.mesh.triangles.iter_mut().for_each(turn_round);
        let edges = pair(&self.mesh.triangles);
        Self { repairs: self.repairs, ..Self::assembled(self.mesh, edges, 1 - self.far) }
    }

    /// Moves the vertices of the mesh; its triangles stay. Costs a small part of building the surface
    /// anew, and answers are those of one that was, as long as triangles stay near their neighbours.
    ///
    /// # Panics
    /// If there are not as many as the mesh has.
    pub fn reshape(&mut self, vertices: &[Vec3]) {
        self.mesh.vertices.copy_from_slice(vertices);
        self.tree.refit(|triangle| self.mesh.corners(triangle));
        self.features.refit(&self.mesh);
        self.bounding_radius = self.mesh.bounding_radius();
    }

    fn assembled(mesh: Mesh, edges: Edges, far: i32) -> Self {
        let tree = Tree::of((0..mesh.triangles.len()).map(|t| mesh.corners(t)));
        let features = Features::of(&mesh, edges.twins);
        let bounding_radius = mesh.bounding_radius();
        Self { mesh, tree, features, far, bounding_radius, repairs: Repairs::default() }
    }

    /// Whether the space outside is solid, and that inside free.
    pub fn is_cavity(&self) -> bool {
        self.far > 0
    }

    /// Its triangles. Those of a cavity face inward: its volume is negative.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// What was repaired when its mesh was loaded.
    pub fn repairs(&self) -> &Repairs {
        &self.repairs
    }

    /// The least box around it, in the part's frame.
    pub fn bounds(&self) -> Bounds {
        self.tree.bounds()
    }

    /// Distance of its farthest point from the origin of the part's frame [m].
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// Puts into `out` the triangles whose boxes meet a box, ascending. Allocates only where `out`
    /// has to grow.
    pub fn triangles_near(&self, bounds: &Bounds, out: &mut Vec<u32>) {
        out.clear();
        self.tree.walk(
            |b| b.meets(bounds),
            |triangle, corners| {
                if Bounds::of(*corners).meets(bounds) {
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

    /// How the surface bends at the three edges of a triangle.
    pub fn edge_kinds(&self, triangle: u32) -> [EdgeKind; 3] {
        self.features.edge_kinds(triangle)
    }

    /// What a vertex of the mesh is to the surface.
    pub fn vertex_kind(&self, vertex: u32) -> VertexKind {
        self.features.vertex_kind(vertex)
    }
}
