//! Deformable surfaces of the scene in the fluid: their vertices come in. What such a surface is to the lattice, see
//! `deformable_shape`; the loads on its facets, see `facet_loads`.

use crate::lattice::collision_kernel::CollisionKernel;
use crate::lattice::error::FluidError;
use crate::solver::lbm_solver::LbmSolver;
use tremie_messages::SurfaceVertex;

impl<T: CollisionKernel> LbmSolver<T> {
    /// See [`crate::LbmFluid::set_surfaces`].
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
