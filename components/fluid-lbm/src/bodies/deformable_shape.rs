//! Shape of a deformable surface: vertices that move by themselves, which a part has not.
//!
//! Such a surface is a body whose frame stands still, with the origin of its section in the scene
//! as its reference. Its cells and links are found anew when a vertex is more than `part_step` from
//! where it was when they were found; what is found so depends on the way that it came. In between,
//! the places where links meet it follow their facets to first order. The wall's velocity at such a
//! place is that of the facet's vertices, linearly in between.

use crate::bodies::facet_sums::{FACETS_PER_PIECE, FacetSums, OnFacet};
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::ledger::add_scaled;
use crate::lattice::units::Units;
use tremie_geometry::{Mesh, Surface};
use tremie_messages::SurfaceVertex;
use tremie_state::{StateError, StateExchange};

/// Of no facet.
pub const NO_FACET: u32 = u32::MAX;

/// A place on a facet: its weights of the three corners.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// The facet; [`NO_FACET`] on a rigid body.
    pub facet: u32,
    weights: [f64; 3],
}

impl Hit {
    /// On a rigid body.
    pub const NONE: Self = Self { facet: NO_FACET, weights: [0.0; 3] };

    /// The place on a facet that is nearest to a point of its plane.
    pub fn on(mesh: &Mesh, facet: u32, point: [f64; 3]) -> Self {
        let corners = mesh.corners(facet as usize).map(<[f64; 3]>::from);
        let from = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| b[k] - a[k]);
        let cross = crate::lattice::d3q19::cross;
        let normal = cross(from(corners[0], corners[1]), from(corners[0], corners[2]));
        let part = |i: usize| {
            let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
            let area = cross(from(point, a), from(point, b));
            crate::lattice::d3q19::dot(area, normal).max(0.0)
        };
        let parts = [part(0), part(1), part(2)];
        let all: f64 = parts.iter().sum();
        // A facet without area is a point or a line.
        let weights = parts.map(|part| if all > 0.0 { part / all } else { 1.0 / 3.0 });
        Self { facet, weights }
    }
}

/// Force of a wall link or a gap link on a facet.
#[derive(Clone, Copy, Debug)]
pub struct Felt {
    /// The facet.
    pub facet: u32,
    /// Place of the gap among those of the item; [`Felt::FLUID`] for a link to the fluid.
    pub gap: u16,
    /// Force; of a gap, for each unit of its density minus 1.
    pub force: [f64; 3],
    /// Place where it acts, from the surface's reference.
    pub at: [f64; 3],
}

impl Felt {
    /// Of no gap.
    pub const FLUID: u16 = u16::MAX;
}

/// Places of the facets of a deformable surface.
#[derive(Clone, Copy, Debug)]
pub struct FacetPlaces<'a> {
    triangles: &'a [[u32; 3]],
    now: &'a [[f64; 3]],
}

/// The vertices of a deformable surface, and the loads on its facets.
#[derive(Clone, Debug)]
pub struct DeformableShape {
    /// Index of the part that carries it.
    pub carrier: usize,
    triangles: Vec<[u32; 3]>,
    /// Places of the vertices, from the reference [m].
    pub now: Vec<[f64; 3]>,
    /// Their velocity, further by what it changed by since the last step; and what was given.
    velocity: Vec<[f64; 3]>,
    given: Vec<[f64; 3]>,
    /// From where they were when links were found to where they are.
    drift: Vec<[f64; 3]>,
    /// Load on each facet.
    pub loads: Vec<OnFacet>,
    /// Sums of what each facet felt: force and torque.
    pub felt: Vec<[ExactSum; 6]>,
    /// Loads that averaging holds back.
    carried: Vec<OnFacet>,
    /// Room for sums over facets, by piece.
    sums: Vec<FacetSums>,
    has_velocity: bool,
}

impl DeformableShape {
    /// At the vertices of a mesh, at rest.
    pub fn new(mesh: &Mesh, carrier: usize) -> Self {
        let rest = vec![[0.0; 3]; mesh.vertices.len()];
        let loads = vec![[[0.0; 3]; 2]; mesh.triangles.len()];
        Self {
            carrier,
            triangles: mesh.triangles.clone(),
            now: mesh.vertices.iter().map(|&vertex| vertex.into()).collect(),
            velocity: rest.clone(),
            given: rest.clone(),
            drift: rest,
            felt: vec![Default::default(); loads.len()],
            carried: loads.clone(),
            sums: vec![FacetSums::default(); loads.len().div_ceil(FACETS_PER_PIECE)],
            loads,
            has_velocity: false,
        }
    }

    /// Takes over vertices; `reference` [m] is in the world. True if any is more than `step` cells
    /// from where links were found on `found`.
    pub fn take(
        &mut self,
        vertices: &[SurfaceVertex],
        reference: [f64; 3],
        (lead, step): (f64, f64),
        found: &Surface,
        units: &Units,
    ) -> bool {
        let mut farthest = 0.0_f64;
        for (k, (vertex, found)) in vertices.iter().zip(&found.mesh().vertices).enumerate() {
            let velocity = vertex.velocity.map(|v| v / units.velocity());
            let before = if self.has_velocity { self.given[k] } else { velocity };
            self.given[k] = velocity;
            for a in 0..3 {
                self.now[k][a] = vertex.position[a] - reference[a];
                self.velocity[k][a] = velocity[a] + lead * (velocity[a] - before[a]);
                self.drift[k][a] = (self.now[k][a] - found[a]) / units.cell;
            }
            farthest = farthest.max(crate::lattice::d3q19::dot(self.drift[k], self.drift[k]));
        }
        self.has_velocity = true;
        farthest > step * step
    }

    /// Keeps vertices and loads as the last step left them, or puts them back.
    ///
    /// # Errors
    /// A state of another surface.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.array("now", &mut self.now)?;
        state.array("given", &mut self.given)?;
        state.array("loads", self.loads.as_flattened_mut())?;
        state.array("carried", self.carried.as_flattened_mut())?;
        self.has_velocity |= state.restores();
        Ok(())
    }

    /// Links are found where vertices are now.
    pub fn settle(&mut self) {
        self.drift.fill([0.0; 3]);
    }

    fn at(&self, values: &[[f64; 3]], hit: Hit) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (corner, weight) in self.triangles[hit.facet as usize].iter().zip(hit.weights) {
            add_scaled(&mut sum, values[*corner as usize], weight);
        }
        sum
    }

    /// Velocity of the wall.
    pub fn velocity_at(&self, hit: Hit) -> [f64; 3] {
        self.at(&self.velocity, hit)
    }

    /// Motion of a point of the surface since links were found [cells].
    pub fn drift_at(&self, hit: Hit) -> [f64; 3] {
        self.at(&self.drift, hit)
    }

    /// Places of the facets.
    pub fn facets(&self) -> FacetPlaces<'_> {
        FacetPlaces { triangles: &self.triangles, now: &self.now }
    }

    /// Places of the facets; their loads, the loads that averaging holds back, and room for sums
    /// over pieces.
    pub fn parts(&mut self) -> (FacetPlaces<'_>, &mut [OnFacet], &mut [OnFacet], &mut [FacetSums]) {
        let facets = FacetPlaces { triangles: &self.triangles, now: &self.now };
        (facets, &mut self.loads, &mut self.carried, &mut self.sums)
    }
}

impl FacetPlaces<'_> {
    /// The corners of a facet, from the reference [m].
    pub fn corners(&self, facet: usize) -> [[f64; 3]; 3] {
        self.triangles[facet].map(|vertex| self.now[vertex as usize])
    }
}
