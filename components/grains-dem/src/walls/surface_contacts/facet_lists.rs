//! Bodies and seats near a surface that deforms, listed for as long as its vertices go no farther
//! than a skin.

use super::{SphereAtSurface, SurfaceContacts};
use crate::Vec3;
use crate::bodies::body_arrays::{Bodies, BoundingSphere, Mobility};
use crate::bodies::mesh_contact::{LookedFrom, WallPoints};
use crate::contact::contact_history::WallContactHistory;
use crate::contact::material_laws::Laws;
use crate::contact::springs::Reduced;
use crate::math::error::GrainsError;
use crate::walls::rigid_seat_contact::Seats;
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::wall_triangle::distance;

/// Input of the lists of a surface: bodies, laws and seats near it.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceSurroundings<'a> {
    pub bodies: &'a Bodies,
    pub laws: &'a Laws,
    pub seats: Seats<'a>,
    /// Skins of the bodies' classes: displacements that the lists allow.
    pub skins: &'a Skins,
}

/// Number of facets in one box; they lie together in most meshes.
const GROUP: usize = 32;

/// An upright box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3 {
    min: Vec3,
    max: Vec3,
}

impl Box3 {
    pub(super) fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let none = Self { min: Vec3::repeat(f64::INFINITY), max: Vec3::repeat(f64::NEG_INFINITY) };
        points.fold(none, |all, x| Self { min: all.min.inf(&x), max: all.max.sup(&x) })
    }

    pub(super) fn is_near(&self, x: Vec3, reach: f64) -> bool {
        (0..3).all(|a| x[a] > self.min[a] - reach && x[a] < self.max[a] + reach)
    }
}

impl SurfaceContacts {
    /// True if a place is within `reach` [m] of the surface's box when facets were listed.
    pub fn is_near(&self, x: Vec3, reach: f64) -> bool {
        self.bounds.is_near(x, reach)
    }

    /// Bodies changed their places in memory, or went far.
    pub fn spoil(&mut self) {
        self.stale = true;
    }

    /// True if lists do not hold for any shape.
    pub fn is_stale(&self) -> bool {
        self.stale
    }

    /// Forgets the bodies that are not among `ids`, which ascend.
    pub fn forget(&mut self, ids: &[u64]) {
        self.entries.retain(|entry| ids.binary_search(&entry.id).is_ok());
    }

    /// True if the present lists do not hold for a shape.
    ///
    /// # Errors
    /// Arrays of another length than the surface has vertices, or numbers that are no points.
    pub fn needs_list(
        &self,
        surface: usize,
        vertices: &[[f64; 3]],
        velocities: &[[f64; 3]],
    ) -> Result<bool, GrainsError> {
        let expected = self.vertices;
        for found in [vertices.len(), velocities.len()] {
            if found != expected {
                return Err(GrainsError::SurfaceVertices { surface, found, expected });
            }
        }
        // Each coordinate by itself, without a branch, and so that what is no number counts as far.
        let limit = self.skin / 3f64.sqrt();
        let (now, then) = (vertices.as_flattened(), self.listed.as_flattened());
        let within = |all: bool, (a, b): (&f64, &f64)| all & ((a - b).abs() <= limit);
        if now.iter().zip(then).fold(true, within) {
            return Ok(self.stale);
        }
        match vertices.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            Some(vertex) => Err(GrainsError::SurfaceNotFinite { surface, vertex }),
            None => Ok(true),
        }
    }

    /// Lists bodies and seats near the surface; contacts keep their history.
    pub fn list(&mut self, vertices: &[[f64; 3]], around: &SurfaceSurroundings<'_>) {
        self.listed.copy_from_slice(vertices);
        self.shape.copy_from_slice(vertices);
        self.travel = 0.0;
        self.stale = false;
        self.seat.list(vertices, self.skin, around.seats);
        std::mem::swap(&mut self.entries, &mut self.spare);
        self.entries.clear();
        self.facets.clear();
        self.start.truncate(1);
        let corner = |triangle: &[u32; 3]| triangle.map(|v| Vec3::from(vertices[v as usize]));
        self.groups.clear();
        let groups = self.triangles.chunks(GROUP);
        self.groups.extend(groups.map(|group| Box3::of(group.iter().flat_map(corner))));
        let all = Box3::of(vertices.iter().map(|&x| x.into()));
        self.bounds = all;
        for (&id, &slot) in around.bodies.ids.iter().zip(&around.bodies.slot) {
            let (slot, bodies) = (slot as usize, around.bodies);
            let BoundingSphere { x, radius } = bodies.balls[slot];
            // The list of bodies may be half spent when this one begins.
            let gap = around.skins.of(radius) + self.skin;
            if bodies.mobility[slot].is_free() && all.is_near(x, radius + gap) {
                self.list_facets(x, radius + gap, corner);
                if self.facets.len() > self.start[self.start.len() - 1] as usize {
                    self.start.push(self.facets.len() as u32);
                    self.enter(id, slot, around);
                }
            }
        }
        self.begin_looks();
        self.found.clear();
        self.found.resize(self.entries.len(), WallPoints::NONE);
    }

    /// Each entry is to look at all its facets.
    pub(super) fn begin_looks(&mut self) {
        self.looked.clear();
        self.looked.resize(self.entries.len(), LookedFrom::NEVER);
        self.distances.clear();
        self.distances.resize(self.facets.len(), 0.0);
    }

    /// Adds the facets near a place.
    fn list_facets(&mut self, x: Vec3, reach: f64, corner: impl Fn(&[u32; 3]) -> [Vec3; 3]) {
        for (g, _) in self.groups.iter().enumerate().filter(|(_, group)| group.is_near(x, reach)) {
            let first = g * GROUP;
            let end = self.triangles.len().min(first + GROUP);
            for (facet, triangle) in (first..).zip(&self.triangles[first..end]) {
                if distance(x, corner(triangle)) < reach {
                    self.facets.push(facet as u32);
                }
            }
        }
    }

    fn enter(&mut self, id: u64, slot: usize, around: &SurfaceSurroundings<'_>) {
        let bodies = around.bodies;
        let known = self.spare.binary_search_by_key(&id, |entry| entry.id).ok();
        let history = known.map_or(WallContactHistory::NONE, |e| self.spare[e].history);
        self.entries.push(SphereAtSurface {
            id,
            body: slot as u32,
            place: 0,
            law: around.laws.between(self.material, bodies.material[slot]),
            reduced: Reduced {
                root_mass: bodies.mobility[slot].root_reduced_mass(Mobility::NONE),
                radius: bodies.balls[slot].radius,
                mean_mass: bodies.mobility[slot].mean_mass(Mobility::NONE),
            },
            history,
        });
    }
}
