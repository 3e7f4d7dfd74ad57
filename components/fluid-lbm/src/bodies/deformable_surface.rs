//! Deformable surfaces of a scene.

use crate::bodies::mesh_body::MeshBody;
use crate::bodies::pose_rounding::Rounding;
use crate::lattice::error::FluidError;
use crate::lattice::units::Units;
use std::ops::Range;
use tremie_geometry::{Frame, Mesh, Surface, Turned, Vec3};
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::Scene;

/// A deformable surface of the scene.
#[derive(Clone, Debug)]
pub struct SoftSurface {
    pub name: String,
    /// Index of the part that carries it.
    pub carrier: usize,
    pub triangles: Vec<[u32; 3]>,
    /// First of its vertices among those of all surfaces, and how many.
    pub first_vertex: usize,
    pub count: usize,
    /// Origin of its section in the scene [m].
    pub reference: [f64; 3],
}

impl SoftSurface {
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
                reference: frame.to_world(surface.pose.position).into(),
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
    pub fn body(
        &self,
        index: usize,
        vertices: &[SurfaceVertex],
        step: f64,
        units: &Units,
    ) -> Result<MeshBody, FluidError> {
        let position = units.position_to_lattice(self.reference);
        let reference: [f64; 3] = std::array::from_fn(|a| units.min[a] + position[a] * units.cell);
        let place =
            |vertex: &SurfaceVertex| Vec3::from_fn(|a, _| vertex.position[a] - reference[a]);
        let vertices = vertices[self.vertices()].iter().map(place).collect();
        let mesh = Mesh { vertices, triangles: self.triangles.clone() };
        let surface = Surface::new(mesh).map_err(|error| FluidError::Surface {
            name: self.name.clone(),
            reason: error.to_string(),
        })?;
        let rounding = Rounding { position, orientation: [0.0, 0.0, 0.0, 1.0], step };
        Ok(MeshBody::deformable(index, surface, self.carrier, rounding, units.cell))
    }
}
