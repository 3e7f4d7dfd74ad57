//! Deformable surfaces of the scene in the fluid: their vertices come in. What such a surface is to the lattice, see
//! `deformable_shape`; the loads on its facets, see `facet_loads`.

use crate::bodies::mesh_body::{PartBody, Rounding};
use crate::lattice::collision_kernel::Collides;
use crate::lattice::error::FluidError;
use crate::lattice::units::Units;
use crate::solver::lbm_solver::Solver;
use std::ops::Range;
use tremie_geometry::{Frame, Mesh, Surface, Turned};
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::Scene;

/// A deformable surface of the scene.
#[derive(Clone, Debug)]
pub struct Soft {
    name: String,
    /// Index of the part that carries it.
    carrier: usize,
    triangles: Vec<[u32; 3]>,
    /// First of its vertices among those of all surfaces, and how many.
    first_vertex: usize,
    count: usize,
    /// Origin of its section in the scene [m].
    reference: [f64; 3],
}

impl Soft {
    /// Those of a scene that was checked.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut first_vertex = 0;
        let of = |surface: &tremie_messages::scene::DeformableSurface| {
            let turned = Turned::of(surface);
            let carrier = scene.parts.iter().position(|part| part.name == surface.carrier);
            let carrier = carrier.unwrap_or_default();
            let frame = Frame::of(&scene.parts[carrier].pose);
            let soft = Self {
                name: surface.name.clone(),
                carrier,
                count: turned.vertex_count(),
                first_vertex,
                reference: frame.to_world(surface.pose.position),
                triangles: turned.triangles,
            };
            first_vertex += soft.count;
            soft
        };
        scene.surfaces.iter().map(of).collect()
    }

    /// Its vertices among those of all surfaces.
    pub fn vertices(&self) -> Range<usize> {
        self.first_vertex..self.first_vertex + self.count
    }

    /// It as a body, `index` being its number among parts and surfaces.
    fn body(
        &self,
        index: usize,
        vertices: &[SurfaceVertex],
        step: f64,
        units: &Units,
    ) -> Result<PartBody, FluidError> {
        let position = units.position_to_lattice(self.reference);
        let reference: [f64; 3] = std::array::from_fn(|a| units.min[a] + position[a] * units.cell);
        let place =
            |vertex: &SurfaceVertex| std::array::from_fn(|a| vertex.position[a] - reference[a]);
        let vertices = vertices[self.vertices()].iter().map(place).collect();
        let mesh = Mesh { vertices, triangles: self.triangles.clone() };
        let surface = Surface::new(mesh).map_err(|error| FluidError::Surface {
            name: self.name.clone(),
            reason: error.to_string(),
        })?;
        let rounding = Rounding { position, orientation: [0.0, 0.0, 0.0, 1.0], step };
        Ok(PartBody::deformable(index, surface, self.carrier, rounding, units.cell))
    }
}

impl<T: Collides> Solver<T> {
    /// See [`crate::FluidLbm::set_surfaces`].
    pub fn set_surfaces(&mut self, vertices: &[SurfaceVertex]) -> Result<(), FluidError> {
        let expected = self.soft_vertices;
        if vertices.len() != expected {
            return Err(FluidError::Vertices { expected, found: vertices.len() });
        }
        if let Some(vertex) = vertices.iter().position(|vertex| !vertex.is_finite()) {
            return Err(FluidError::NonFiniteVertex { vertex });
        }
        if !self.waiting.is_empty() {
            let step = self.pose_spacing;
            let mut parts = Vec::new();
            for (k, soft) in self.waiting.iter().enumerate() {
                parts.push(soft.body(self.parts + k, vertices, step, &self.units)?);
            }
            let softs = std::mem::take(&mut self.waiting);
            self.bodies.add_softs(softs, parts, &self.layout.grid);
            self.list_items();
        }
        self.bodies.vertices.clear();
        self.bodies.vertices.extend_from_slice(vertices);
        Ok(())
    }

    /// That vertices of deformable surfaces came, if the scene has some.
    pub(crate) fn check_surfaces(&self) -> Result<(), FluidError> {
        match self.waiting.is_empty() {
            true => Ok(()),
            false => Err(FluidError::Vertices { expected: self.soft_vertices, found: 0 }),
        }
    }
}
