//! Deformable surfaces of the scene in the fluid: their vertices come in. For such a surface on the
//! lattice see `deformable_shape`; for the loads on its facets, see `facet_loads`.

use crate::bodies::body_list::{Bodies, BodySite};
use crate::bodies::deformable_surface::SoftSurface;
use crate::bodies::mesh_body::MeshBody;
use crate::lattice::error::FluidError;
use crate::lattice::units::Units;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::SurfaceVertex;
use tremie_messages::scene::Scene;
use tremie_state::{StateError, StateExchange};

/// Surfaces that become bodies with their first vertices.
pub struct AwaitedSurfaces {
    /// Those whose vertices have not come yet: all or none.
    waiting: Vec<SoftSurface>,
    /// Vertices of all surfaces of the scene.
    vertices: usize,
    /// Places where they came first [m]: the search for facets near a point is made for these.
    first: Vec<[f64; 3]>,
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
        let (parts, first) = (scene.parts.len(), Vec::new());
        Self { waiting, vertices, first, parts, pose_spacing }
    }

    /// Keeps the surfaces that have become bodies, or makes them so again, with these handles.
    ///
    /// # Errors
    /// A state of other surfaces.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        (bodies, handles): (&mut Bodies, &[u32]),
        site: &mut BodySite<'_>,
    ) -> Result<(), StateError> {
        state.list("first", &mut self.first)?;
        if state.restores() && !handles.is_empty() {
            let vertex = |&position| SurfaceVertex { position, velocity: [0.0; 3] };
            let vertices: Vec<_> = self.first.iter().map(vertex).collect();
            if handles.len() != self.waiting.len() {
                return state.unfit("the state is that of other surfaces");
            }
            match self.check_vertices(&vertices).and_then(|()| self.made(&vertices, site.units)) {
                Ok(parts) => {
                    let softs = std::mem::take(&mut self.waiting);
                    bodies.place_softs(softs, parts, handles, &site.layout.grid);
                }
                Err(error) => return state.unfit(format!("the state of a surface: {error}")),
            }
        }
        bodies.exchange_softs(state, site)
    }

    /// Those that wait, as bodies.
    fn made(&self, vertices: &[SurfaceVertex], units: &Units) -> Result<Vec<MeshBody>, FluidError> {
        let all = self.waiting.iter().enumerate();
        all.map(|(k, soft)| soft.body(self.parts + k, vertices, self.pose_spacing, units)).collect()
    }

    fn check_vertices(&self, vertices: &[SurfaceVertex]) -> Result<(), FluidError> {
        let expected = self.vertices;
        if vertices.len() != expected {
            return Err(FluidError::Vertices { expected, found: vertices.len() });
        }
        match vertices.iter().position(|vertex| !vertex.is_finite()) {
            Some(vertex) => Err(FluidError::NonFiniteVertex { vertex }),
            None => Ok(()),
        }
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
        self.check_vertices(vertices)?;
        let are_new = !self.waiting.is_empty();
        if are_new {
            let parts = self.made(vertices, units)?;
            self.first = vertices.iter().map(|vertex| vertex.position).collect();
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
