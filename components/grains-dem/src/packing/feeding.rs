//! Spheres that come one by one into a region where others are.

use super::{
    Region, Surroundings,
    insertion::{Grid, fits},
};
use crate::{Vec3, bodies::Ball, random::Random};
use tremie_messages::scene::Packing;

/// The side of a region from which spheres come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Upstream {
    pub axis: usize,
    /// 0 for the lower side, 1 for the upper.
    pub side: usize,
    /// How far from there centres lie that are tried first [m].
    pub depth: f64,
}

/// A region with what is in it.
pub(crate) struct Feeding<'a> {
    region: Region<'a>,
    grid: Grid,
}

impl<'a> Feeding<'a> {
    /// The region of a packing, for spheres up to a radius [m].
    pub fn new(packing: &Packing, around: &Surroundings<'a>, largest: f64) -> Self {
        let region = Region::new(packing, around, largest);
        let reach = region.obstacles.iter().fold(largest, |r, ball| r.max(ball.radius));
        let mut grid = Grid::new(&region, 2.0 * reach, region.obstacles.len());
        region.obstacles.iter().for_each(|&ball| grid.add(ball));
        Self { region, grid }
    }

    /// Volume of the region outside of parts and walls [m³], from points between them, if there are any.
    pub fn free_volume(&self) -> f64 {
        const POINTS: usize = 48;
        let (min, size) = (self.region.bounds.min, self.region.bounds.size);
        let whole = size.x * size.y * size.z;
        if self.region.parts.is_empty() && self.region.walls.is_empty() {
            return whole;
        }
        let at = |k: usize, a: usize| min[a] + size[a] * (k as f64 + 0.5) / POINTS as f64;
        let free = |ball: &Ball| {
            self.region.walls.iter().all(|wall| wall.overlap(ball) <= 0.0)
                && self.region.depth_in_parts(ball).0 <= 0.0
        };
        let places = (0..POINTS * POINTS * POINTS).map(|k| {
            let x = Vec3::new(
                at(k % POINTS, 0),
                at(k / POINTS % POINTS, 1),
                at(k / (POINTS * POINTS), 2),
            );
            Ball { x, radius: 0.0 }
        });
        whole * places.filter(free).count() as f64 / (POINTS * POINTS * POINTS) as f64
    }

    /// Puts a sphere where it overlaps nothing; `None` when none of the places that were tried will do.
    pub fn add(
        &mut self,
        radius: f64,
        upstream: Option<Upstream>,
        tries: u32,
        random: &mut Random,
    ) -> Option<Ball> {
        let found = (0..tries).find_map(|attempt| {
            let first = upstream.filter(|_| attempt < tries.div_ceil(2));
            let ball = Ball { x: self.centre(radius, first, random), radius };
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
