//! Spheres that come one by one into a region where others are.

use super::{
    PackingRegion, PackingSurroundings,
    insertion::{Grid, fits},
};
use crate::Vec3;
use crate::math::random::Random;
use crate::space::rigid_body::BoundingSphere;
use crate::space::solid_part::SolidPart;
use tremie_messages::scene::Packing;

/// The side of a region from which spheres come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Upstream {
    /// Its axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// 0 for the lower side, 1 for the upper.
    pub side: usize,
    /// Depth of the layer from there in which centres are tried first [m].
    pub depth: f64,
}

impl Upstream {
    /// Mean distance from there of the centres tried first, for a sphere of this `radius` in a
    /// region of this `length` [m].
    pub fn mean_distance(&self, radius: f64, length: f64) -> f64 {
        radius + 0.5 * self.depth.min((length - 2.0 * radius).max(0.0))
    }
}

/// A region with its spheres and parts.
pub struct Feeding<'a, P> {
    region: PackingRegion<'a, P>,
    grid: Grid,
}

impl<'a, P: SolidPart> Feeding<'a, P> {
    /// The region of a packing, for spheres up to a radius [m].
    pub fn new(packing: &Packing, around: &PackingSurroundings<'a, P>, largest: f64) -> Self {
        let region = PackingRegion::new(packing, around, largest);
        let mut grid = Grid::new(&region, std::iter::once(largest));
        region.obstacles.iter().for_each(|&ball| grid.add(ball));
        Self { region, grid }
    }

    /// Volume of the region outside of parts and walls [m³], from points between them, if there are
    /// any.
    pub fn free_volume(&self) -> f64 {
        self.free_slices(2, 0).iter().sum()
    }

    /// That of each slice of equal thickness across an axis, from a side of the region on [m³].
    pub fn free_slices(&self, axis: usize, side: usize) -> Vec<f64> {
        const POINTS: usize = 48;
        let (min, size) = (self.region.bounds.min, self.region.bounds.size);
        let slice = size.x * size.y * size.z / POINTS as f64;
        if self.region.parts.is_empty() && self.region.walls.is_empty() {
            return vec![slice; POINTS];
        }
        let at = |k: usize, a: usize| min[a] + size[a] * (k as f64 + 0.5) / POINTS as f64;
        let is_free = |x: Vec3| {
            let point = BoundingSphere { x, radius: 0.0 };
            self.region.walls.iter().all(|wall| wall.overlap(&point) <= 0.0)
                && self.region.depth_in_parts(&point).0 <= 0.0
        };
        let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
        let of = |k: usize| {
            let k = if side == 0 { k } else { POINTS - 1 - k };
            let places = (0..POINTS * POINTS).map(|point| {
                let mut x = Vec3::zeros();
                x[axis] = at(k, axis);
                x[one] = at(point % POINTS, one);
                x[other] = at(point / POINTS, other);
                x
            });
            let count = places.filter(|&x| is_free(x)).count();
            slice * count as f64 / (POINTS * POINTS) as f64
        };
        (0..POINTS).map(of).collect()
    }

    /// Puts a sphere where it overlaps nothing; `None` when none of the places that were tried will
    /// do.
    pub fn add(
        &mut self,
        radius: f64,
        upstream: Option<Upstream>,
        tries: u32,
        random: &mut Random,
    ) -> Option<BoundingSphere> {
        let found = (0..tries).find_map(|attempt| {
            let first = upstream.filter(|_| attempt < tries.div_ceil(2));
            let ball = BoundingSphere { x: self.centre(radius, first, random), radius };
            fits(&self.region, &self.grid, &ball).then_some(ball)
        })?;
        self.grid.add(found);
        Some(found)
    }

    fn centre(&self, radius: f64, upstream: Option<Upstream>, random: &mut Random) -> Vec3 {
        let mut x = self.region.random_centre(radius, random);
        if let Some(Upstream { axis, side, depth }) = upstream
            && !self.region.bounds.periodic[axis]
        {
            let (min, size) = (self.region.bounds.min[axis], self.region.bounds.size[axis]);
            // The number that was drawn for the whole length goes to the slab.
            let room = (size - 2.0 * radius).max(0.0);
            let slab = room.min(depth);
            let part = if room > 0.0 { (x[axis] - min - radius) / room } else { 0.0 };
            let from = if side == 0 { min + radius } else { min + size - radius - slab };
            x[axis] = from + slab * part;
        }
        x
    }
}
