//! Random sequential insertion: each sphere at the first random place where it fits.

use super::{PackingRegion, place_stream};
use crate::Vec3;
use crate::neighbours::size_classes::Skins;
use crate::space::periodic::PeriodicBox;
use crate::space::rigid_body::BoundingSphere;
use crate::space::solid_part::SolidPart;

/// Places tried for one sphere before insertion is given up.
const TRIES: usize = 2000;

const NONE: u32 = u32::MAX;

/// Numbers of the spheres in the order in which they are inserted: the largest first.
pub(super) fn order(radii: &[f64]) -> Vec<usize> {
    let mut largest_first: Vec<usize> = (0..radii.len()).collect();
    largest_first.sort_by(|&a, &b| radii[b].total_cmp(&radii[a]).then(a.cmp(&b)));
    largest_first
}

/// Inserts spheres of the given radii, and gives them in that [`order`]; `None` when one does not
/// fit.
pub(super) fn insert(
    region: &PackingRegion<'_, impl SolidPart>,
    radii: &[f64],
    seed: u64,
) -> Option<Vec<BoundingSphere>> {
    let mut grid = Grid::new(region, radii.iter().copied());
    for &obstacle in &region.obstacles {
        grid.add(obstacle);
    }
    for index in order(radii) {
        let radius = radii[index];
        let mut random = place_stream(seed, index);
        let mut places = (0..TRIES)
            .map(|_| BoundingSphere { x: region.random_centre(radius, &mut random), radius });
        grid.add(places.find(|ball| fits(region, &grid, ball))?);
    }
    Some(grid.balls.split_off(region.obstacles.len()))
}

pub(super) fn fits(
    region: &PackingRegion<'_, impl SolidPart>,
    grid: &Grid,
    ball: &BoundingSphere,
) -> bool {
    region.walls.iter().all(|wall| wall.overlap(ball) <= 0.0)
        && !grid.overlaps(ball)
        && region.depth_in_parts(ball).0 <= 0.0
}

/// Cells with linked lists of the spheres inserted so far, in levels by size as
/// [`Cells`](crate::neighbours::linked_cells::LinkedCells) has them.
pub(super) struct Grid {
    bounds: PeriodicBox,
    skins: Skins,
    levels: Vec<InsertionLevel>,
    next: Vec<u32>,
    balls: Vec<BoundingSphere>,
}

/// The cells of one class.
struct InsertionLevel {
    min: Vec3,
    edge: Vec3,
    count: [i64; 3],
    first: Vec<u32>,
    /// Radius of the largest sphere that was added [m].
    largest: f64,
}

impl Grid {
    /// For the obstacles of a region and spheres of the given radii; others may come too.
    pub fn new(
        region: &PackingRegion<'_, impl SolidPart>,
        radii: impl Iterator<Item = f64> + Clone,
    ) -> Self {
        let radii = region.obstacles.iter().map(|ball| ball.radius).chain(radii);
        let skins = Skins::new(radii.clone().map(|radius| [2.0 * radius; 2]), 0.0, 0.0);
        let mut members = vec![0; skins.count()];
        radii.for_each(|radius| members[skins.class(radius)] += 1);
        let level = |(class, &members): (usize, &i64)| {
            InsertionLevel::new(region, skins.largest(class), members)
        };
        let levels = members.iter().enumerate().map(level).collect();
        let spheres = members.iter().sum::<i64>() as usize;
        Self {
            bounds: region.bounds.clone(),
            levels,
            skins,
            next: Vec::with_capacity(spheres),
            balls: Vec::with_capacity(spheres),
        }
    }

    pub fn add(&mut self, ball: BoundingSphere) {
        let level = &mut self.levels[self.skins.class(ball.radius)];
        let slot = level.slot([0, 1, 2].map(|a| level.cell(ball.x[a], a)));
        level.largest = level.largest.max(ball.radius);
        self.next.push(level.first[slot]);
        level.first[slot] = self.balls.len() as u32;
        self.balls.push(ball);
    }

    fn overlaps(&self, ball: &BoundingSphere) -> bool {
        self.levels.iter().any(|level| self.overlaps_at(level, ball))
    }

    fn overlaps_at(&self, level: &InsertionLevel, ball: &BoundingSphere) -> bool {
        if level.largest == 0.0 {
            return false;
        }
        let reach = ball.radius + level.largest;
        let around = |a: usize| level.cells(ball.x[a], reach, a, self.bounds.periodic[a]);
        around(2)
            .any(|z| around(1).any(|y| around(0).any(|x| self.overlaps_in(level, [x, y, z], ball))))
    }

    fn overlaps_in(&self, level: &InsertionLevel, cell: [i64; 3], ball: &BoundingSphere) -> bool {
        let mut k = level.first[level.slot(cell)];
        while k != NONE {
            let other = &self.balls[k as usize];
            let reach = ball.radius + other.radius;
            if self.bounds.shortest(other.x - ball.x).norm_squared() < reach * reach {
                return true;
            }
            k = self.next[k as usize];
        }
        false
    }
}

impl InsertionLevel {
    /// Cells no smaller than `edge` [m], and few for so many spheres.
    fn new(region: &PackingRegion<'_, impl SolidPart>, edge: f64, spheres: i64) -> Self {
        let (min, size) = (region.bounds.min, region.bounds.size);
        let mut least = edge;
        let count = loop {
            // Cells fill the box exactly, so that they fit together where it wraps around.
            let count = [0, 1, 2].map(|a| ((size[a] / least) as i64).clamp(1, 1 << 20));
            if count.iter().product::<i64>() <= 4 * spheres + 64 {
                break count;
            }
            least *= 1.1;
        };
        Self {
            min,
            edge: Vec3::from_fn(|a, _| size[a] / count[a] as f64),
            first: vec![NONE; count.iter().product::<i64>() as usize],
            count,
            largest: 0.0,
        }
    }

    /// The cells along an axis that may hold what lies within `reach` [m] of a place, each once.
    fn cells(&self, x: f64, reach: f64, a: usize, wraps: bool) -> impl Iterator<Item = i64> {
        let count = self.count[a];
        // A hair more than it is: places of bodies were rounded too.
        let place = |x: f64| libm::floor((x - self.min[a]) / self.edge[a]) as i64;
        let reach = reach + 1e-6 * self.edge[a];
        let (low, high) = (place(x - reach), place(x + reach));
        let (low, high) = match wraps {
            true => (low, high.min(low + count - 1)),
            false => (low.clamp(0, count - 1), high.clamp(0, count - 1)),
        };
        (low..=high).map(move |cell| cell.rem_euclid(count))
    }

    /// The cell of a place along an axis; what lies outside belongs to the nearest one.
    fn cell(&self, x: f64, a: usize) -> i64 {
        let cell = libm::floor((x - self.min[a]) / self.edge[a]) as i64;
        cell.clamp(0, self.count[a] - 1)
    }

    fn slot(&self, cell: [i64; 3]) -> usize {
        ((cell[2] * self.count[1] + cell[1]) * self.count[0] + cell[0]) as usize
    }
}
