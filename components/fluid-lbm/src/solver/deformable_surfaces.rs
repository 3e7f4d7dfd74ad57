//! Deformable surfaces of the scene in the fluid: their vertices come in. For such a surface on the
//! lattice see `deformable_shape`; for the loads on its facets, see `facet_loads`.

use crate::bodies::body_list::Bodies;
use crate::bodies::deformable_surface::SoftSurface;
use crate::lattice::error::FluidError;
use crate::lattice::units::Units;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::Scene;

/// Surfaces that become bodies with their first vertices.
pub struct AwaitedSurfaces {
    /// Those whose vertices have not come yet: all or none.
    waiting: Vec<SoftSurface>,
    /// Vertices of all surfaces of the scene.
    vertices: usize,
    /// Parts of the scene: surfaces are numbered after them.
    parts: usize,
    /// Distance that a vertex moves until cells and links are found anew [cells].
    pose_spacing: f64,
}

impl AwaitedSurfaces {
    /// Those of a scene.
    pub fn new(scene: &Scene, pose_spacing: f64) -> Self {
        let waiting = SoftSurface::all(scene);
        let vertices = waiting.iter().map(|soft| soft.vertices().len()).sum();
        Self { waiting, vertices, parts: scene.parts.len(), pose_spacing }
    }

    /// True if the scene has any.
    pub fn are_any(&self) -> bool {
        self.vertices > 0
    }

    /// Gives all surfaces their vertices; true if they have become bodies by it.
    ///
    /// # Errors
    /// See [`crate::LbmFluid::set_surfaces`].
    pub fn take(
        &mut self,
        vertices: &[SurfaceVertex],
        bodies: &mut Bodies,
        units: &Units,
        grid: &Grid,
    ) -> Result<bool, FluidError> {
        let expected = self.vertices;
        if vertices.len() != expected {
            return Err(FluidError::Vertices { expected, found: vertices.len() });
        }
        if let Some(vertex) = vertices.iter().position(|vertex| !vertex.is_finite()) {
            return Err(FluidError::NonFiniteVertex { vertex });
        }
        let are_new = !self.waiting.is_empty();
        if are_new {
            let mut parts = Vec::new();
            for (k, soft) in self.waiting.iter().enumerate() {
                parts.push(soft.body(self.parts + k, vertices, self.pose_spacing, units)?);
            }
            bodies.add_softs(std::mem::take(&mut self.waiting), parts, grid);
        }
        bodies.vertices.clear();
        bodies.vertices.extend_from_slice(vertices);
        Ok(are_new)
    }

    /// That vertices of deformable surfaces came, if the scene has some.
    pub fn check(&self) -> Result<(), FluidError> {
        match self.waiting.is_empty() {
            true => Ok(()),
            false => Err(FluidError::Vertices { expected: self.vertices, found: 0 }),
        }
    }
}
