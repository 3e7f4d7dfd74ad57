//! Random sequential insertion: each sphere at the first random place where it fits.

use super::{Region, place_stream};
use crate::{Vec3, bodies::Ball, periodic::PeriodicBox};

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
pub(super) fn insert(region: &Region<'_>, radii: &[f64], seed: u64) -> Option<Vec<Ball>> {
    let reach = region.obstacles.iter().map(|ball| ball.radius).chain(radii.iter().copied());
    let mut grid = Grid::new(region, 2.0 * reach.fold(0.0, f64::max), radii.len());
    for &obstacle in &region.obstacles {
        grid.add(obstacle);
    }
    for index in order(radii) {
        let radius = radii[index];
        let mut random = place_stream(seed, index);
        let mut places =
            (0..TRIES).map(|_| Ball { x: region.random_centre(radius, &mut random), radius });
        grid.add(places.find(|ball| fits(region, &grid, ball))?);
    }
    Some(grid.balls.split_off(region.obstacles.len()))
}

pub(super) fn fits(region: &Region<'_>, grid: &Grid, ball: &Ball) -> bool {
    region.walls.iter().all(|wall| wall.overlap(ball) <= 0.0)
        && !grid.overlaps(ball)
        && region.depth_in_parts(ball).0 <= 0.0
}

/// Cells with linked lists of the spheres inserted so far.
pub(super) struct Grid {
    bounds: PeriodicBox,
    edge: Vec3,
    count: [i64; 3],
    first: Vec<u32>,
    next: Vec<u32>,
    balls: Vec<Ball>,
}

impl Grid {
    pub fn new(region: &Region<'_>, smallest_edge: f64, spheres: usize) -> Self {
        let size = region.bounds.size;
        let mut least = smallest_edge;
        let count = loop {
            // Cells fill the box exactly, so that they fit together where it wraps around.
            let count = [0, 1, 2].map(|a| ((size[a] / least) as i64).max(1));
            if count.iter().product::<i64>() <= 4 * spheres as i64 + 64 {
                break count;
            }
            least *= 1.1;
        };
        Self {
            bounds: region.bounds.clone(),
            edge: Vec3::from_fn(|a, _| size[a] / count[a] as f64),
            count,
            first: vec![NONE; count.iter().product::<i64>() as usize],
            next: Vec::with_capacity(spheres),
            balls: Vec::with_capacity(spheres),
        }
    }

    pub fn add(&mut self, ball: Ball) {
        let slot = self.slot(self.cell(ball.x));
        self.next.push(self.first[slot]);
        self.first[slot] = self.balls.len() as u32;
        self.balls.push(ball);
    }

    fn overlaps(&self, ball: &Ball) -> bool {
        let home = self.cell(ball.x);
        let around = |a: usize| {
            let (count, wraps) = (self.count[a], self.bounds.periodic[a]);
            let cells = home[a] - 1..=home[a] + 1;
            cells
                .filter(move |cell| wraps || (0..count).contains(cell))
                .map(move |cell| cell.rem_euclid(count))
        };
        around(2).any(|z| around(1).any(|y| around(0).any(|x| self.overlaps_in([x, y, z], ball))))
    }

    fn overlaps_in(&self, cell: [i64; 3], ball: &Ball) -> bool {
        let mut k = self.first[self.slot(cell)];
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

    /// The cell of a place; what lies outside belongs to the nearest one.
    fn cell(&self, x: Vec3) -> [i64; 3] {
        [0, 1, 2].map(|a| {
            let cell = libm::floor((x[a] - self.bounds.min[a]) / self.edge[a]) as i64;
            cell.clamp(0, self.count[a] - 1)
        })
    }

    fn slot(&self, cell: [i64; 3]) -> usize {
        ((cell[2] * self.count[1] + cell[1]) * self.count[0] + cell[0]) as usize
    }
}
