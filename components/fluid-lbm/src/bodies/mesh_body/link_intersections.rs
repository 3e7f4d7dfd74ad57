//! Intersections of links with the surface of a body.

use super::MeshBody;
use crate::bodies::deformable_shape::{Hit, NO_FACET};
use crate::lattice::d3q19::dot;
use tremie_geometry::{Bounds, Vec3};

/// Links that meet the surface at a smaller cosine do not follow its motion: their end is not where
/// a flat wall's would be.
const GRAZING: f64 = 0.1;

/// Intersection of a link with a part's surface.
#[derive(Clone, Copy, Debug)]
pub struct Intersection {
    /// As part of the link's length, in `(0, 1]`.
    pub q: f64,
    /// By how much `q` grows for each cell that the surface moves: `n / (c.n)`, `n` its normal;
    /// zero where it is met at a grazing angle.
    pub slope: [f64; 3],
    /// Place on the surface, if that can deform.
    pub hit: Hit,
}

/// Facets near a cell at most, to try each for each of its links; where there are more, the
/// surface's tree is faster.
const MOST_FACETS: usize = 16;

/// Facets near a cell, for the links that begin there.
#[derive(Clone, Debug, Default)]
pub struct NearFacets {
    list: Vec<u32>,
    is_complete: bool,
}

impl NearFacets {
    /// Room for as many as there may be.
    pub fn make_room(&mut self) {
        self.list.reserve((MOST_FACETS + 1).saturating_sub(self.list.len()));
    }
}

impl MeshBody {
    /// First intersection of a link between the centres of cells with the surface, as part of the
    /// link's length, in `(0, 1]`; half-way if there is none.
    pub fn meet(&self, from: [i32; 3], c: [i32; 3]) -> f64 {
        self.meet_facet(from, c).0
    }

    /// As [`MeshBody::meet`], and the facet, if the surface can deform.
    pub fn meet_facet(&self, from: [i32; 3], c: [i32; 3]) -> (f64, u32) {
        let from = self.own(from);
        let to = std::array::from_fn(|a| from[a] + c[a]);
        let (start, end) = (self.point(from), self.point(to));
        match self.surface.first_crossing(start, end) {
            Some(crossing) => {
                let facet = self.shape.as_ref().map_or(NO_FACET, |_| crossing.triangle);
                (crossing.fraction.clamp(f64::MIN_POSITIVE, 1.0), facet)
            }
            None => (0.5, self.hit_between(start, end).facet),
        }
    }

    /// The place on a deformable surface nearest to the middle of a link that does not meet it.
    fn hit_between(&self, start: [f64; 3], end: [f64; 3]) -> Hit {
        if self.shape.is_none() {
            return Hit::NONE;
        }
        let closest = self.surface.closest(Vec3::from_fn(|a, _| 0.5 * (start[a] + end[a])));
        Hit::on(self.surface.mesh(), closest.triangle, closest.point.into())
    }

    /// Finds the facets that links from a cell may meet.
    pub fn facets_near(&self, at: [i32; 3], facets: &mut NearFacets) {
        let reach: [f64; 3] = std::array::from_fn(|k| {
            let along = |a: usize| {
                let mut axis = [0.0; 3];
                axis[a] = self.cell;
                self.frame.turn_to_part(axis)[k].abs()
            };
            (along(0) + along(1) + along(2)) * (1.0 + 1e-9)
        });
        let centre = self.point(self.own(at));
        let min = Vec3::from_fn(|k, _| centre[k] - reach[k]);
        let max = Vec3::from_fn(|k, _| centre[k] + reach[k]);
        let bounds = Bounds { min, max };
        facets.is_complete = self.surface.triangles_in(&bounds, MOST_FACETS, &mut facets.list);
    }

    /// As [`MeshBody::meet`], among the facets near `from`.
    pub fn meet_among(&self, facets: &NearFacets, from: [i32; 3], c: [i32; 3]) -> Intersection {
        self.meets_among(facets, from, c).unwrap_or_else(|| {
            let from = self.own(from);
            let to = std::array::from_fn(|a| from[a] + c[a]);
            let hit = self.hit_between(self.point(from), self.point(to));
            Intersection { q: 0.5, slope: [0.0; 3], hit }
        })
    }

    /// First intersection of a link with the surface, among the facets near its beginning or its
    /// end; none if it does not meet it.
    pub fn meets_among(
        &self,
        facets: &NearFacets,
        from: [i32; 3],
        c: [i32; 3],
    ) -> Option<Intersection> {
        let from = self.own(from);
        let to = std::array::from_fn(|a| from[a] + c[a]);
        let (start, end) = (self.point(from), self.point(to));
        let crossing = if facets.is_complete {
            self.surface.first_crossing_among(&facets.list, start, end)
        } else {
            self.surface.first_crossing(start, end)
        }?;
        let hit = self.shape.as_ref().map_or(Hit::NONE, |_| {
            let point = |a: usize| start[a] + crossing.fraction * (end[a] - start[a]);
            Hit::on(self.surface.mesh(), crossing.triangle, std::array::from_fn(point))
        });
        let normal: [f64; 3] =
            self.frame.turn_to_world(self.surface.normal(crossing.triangle)).into();
        let c = c.map(f64::from);
        let along = dot(normal, c);
        let is_steep = along * along > GRAZING * GRAZING * dot(c, c);
        Some(Intersection {
            q: crossing.fraction.clamp(f64::MIN_POSITIVE, 1.0),
            slope: if is_steep { normal.map(|n| n / along) } else { [0.0; 3] },
            hit,
        })
    }
}
