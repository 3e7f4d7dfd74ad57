//! Dense packings: spheres inserted at random while they are small, grown, and pushed apart until
//! none overlaps.
//!
//! Small spheres keep a distance from each other that full-grown ones inherit: the packing is as
//! even over long distances as one by insertion. Without it, as points thrown at random, it would
//! have dense and loose parts, through which a fluid passes up to twice as fast.
//!
//! Each sweep moves every overlapping pair apart along its line of centres by its overlap, half
//! each, one pair after the other (a projection method as in Müller et al., *J. Vis. Commun.
//! Image R.* 18, 2007). Spheres are taken a little too large, so that the true ones come free
//! after a finite number of sweeps.

use super::{PackingRegion, insertion, place_stream};
use crate::Vec3;
use crate::neighbours::cell_pairs::{CellPairs, Neighbour};
use crate::neighbours::linked_cells::LinkedCells;
use crate::neighbours::size_classes::{Leash, Skins};
use crate::space::rigid_body::{BoundingSphere, Mobility};
use crate::space::solid_part::SolidPart;
use core::f64::consts::PI;

/// Sweeps before the fraction is called out of reach.
const SWEEPS: usize = 4000;

/// To tell what was within reach, spheres shrink by this factor after each further few sweeps.
const SHRINK: f64 = 0.995;
const SWEEPS_EACH: usize = 100;
const SMALLEST_FACTOR: f64 = 0.1;

/// Excess of the radii of the relaxed spheres, over the true ones.
const SLACK: f64 = 1e-3;

/// Skin of the neighbour lists, in largest diameters of their class.
const SKIN: f64 = 0.15;

/// Overlap over the reach of its pair that passes as none: rounding.
const CLEAR: f64 = 1e-12;

/// Solid fractions to which small spheres are inserted: the first for which there is room.
const SPARSE: [f64; 3] = [0.25, 0.15, 0.08];

/// Spheres of the given radii without overlap; or the factor on all radii at which they came free.
pub(super) fn relax(
    region: &PackingRegion<'_, impl SolidPart>,
    radii: &[f64],
    seed: u64,
) -> Result<Vec<BoundingSphere>, f64> {
    let mut crowd = OverlappingSpheres::new(region, radii, seed);
    if crowd.comes_free(SWEEPS) {
        crowd.balls.truncate(radii.len());
        for ball in &mut crowd.balls {
            ball.x = region.bounds.wrap(ball.x);
        }
        return Ok(crowd.balls);
    }
    let mut factor = 1.0;
    while factor > SMALLEST_FACTOR {
        factor *= SHRINK;
        crowd.shrink();
        if crowd.comes_free(SWEEPS_EACH) {
            return Err(factor);
        }
    }
    Err(0.0)
}

/// Start positions: those of the spheres while they are small enough to fit, or random places if
/// they never fit.
fn starts(
    region: &PackingRegion<'_, impl SolidPart>,
    radii: &[f64],
    seed: u64,
) -> Vec<BoundingSphere> {
    let small = SPARSE.iter().find_map(|&fraction| grown(region, radii, fraction, seed));
    small.unwrap_or_else(|| {
        (0..radii.len()).map(|index| start(region, radii[index], seed, index)).collect()
    })
}

/// The spheres, where they fit if they are so small that they fill a fraction of the region.
fn grown(
    region: &PackingRegion<'_, impl SolidPart>,
    radii: &[f64],
    fraction: f64,
    seed: u64,
) -> Option<Vec<BoundingSphere>> {
    let volume: f64 = radii.iter().map(|r| 4.0 / 3.0 * PI * r * r * r).sum();
    let size = region.bounds.size;
    let share = libm::cbrt(fraction * size.x * size.y * size.z / volume).min(1.0);
    let small: Vec<f64> = radii.iter().map(|r| share * r).collect();
    let inserted = insertion::insert(region, &small, seed)?;
    let order = insertion::order(&small).into_iter();
    Some(
        order
            .zip(inserted)
            .map(|(index, ball)| BoundingSphere { radius: radii[index], ..ball })
            .collect(),
    )
}

/// A sphere at the first of its random places whose centre is in no part. One that began in a part
/// could be driven out through a face behind which there is no room.
fn start(
    region: &PackingRegion<'_, impl SolidPart>,
    radius: f64,
    seed: u64,
    index: usize,
) -> BoundingSphere {
    let mut random = place_stream(seed, index);
    let mut place = || BoundingSphere { x: region.random_centre(radius, &mut random), radius };
    let mut ball = place();
    for _ in 0..TRIES {
        if region.depth_in_parts(&ball).0 <= radius {
            break;
        }
        ball = place();
    }
    ball
}

/// Places tried for a sphere that begins in a part.
const TRIES: usize = 1000;

/// The spheres of the packing, then the obstacles.
struct OverlappingSpheres<'a, P> {
    region: &'a PackingRegion<'a, P>,
    free: usize,
    balls: Vec<BoundingSphere>,
    mobility: Vec<Mobility>,
    cells: LinkedCells,
    list: CellPairs,
    reference: Vec<Vec3>,
    /// Position of each sphere at its last search of parts, and its clearance from parts there [m].
    clear: Vec<(Vec3, f64)>,
}

impl<'a, P: SolidPart> OverlappingSpheres<'a, P> {
    fn new(region: &'a PackingRegion<'a, P>, radii: &[f64], seed: u64) -> Self {
        let mut balls = starts(region, radii, seed);
        balls.extend(&region.obstacles);
        let mobile = Mobility { inverse_mass: 1.0, ..Mobility::NONE };
        let mut mobility = vec![mobile; radii.len()];
        mobility.resize(balls.len(), Mobility::NONE);
        let spans = balls.iter().map(|ball| [2.0 * ball.radius; 2]);
        let skins = Skins::new(spans, SKIN, 0.0);
        let mut crowd = Self {
            region,
            free: radii.len(),
            cells: LinkedCells::new(region.bounds.clone(), skins),
            list: CellPairs::default(),
            reference: Vec::new(),
            clear: vec![(Vec3::zeros(), 0.0); radii.len()],
            balls,
            mobility,
        };
        crowd.list_neighbours();
        crowd
    }

    fn list_neighbours(&mut self) {
        let bounds = &self.region.bounds;
        for ball in &mut self.balls[..self.free] {
            ball.x = bounds.wrap(ball.x);
        }
        let (cells, balls, mobility) = (&mut self.cells, &self.balls, &self.mobility);
        cells.sort(balls);
        self.list.fill(cells, &bounds.shifts, balls, mobility);
        self.reference.clear();
        self.reference.extend(balls.iter().map(|ball| ball.x));
    }

    fn sweep(&mut self) {
        for i in 0..self.balls.len() {
            for k in self.list.row(i) {
                self.push_apart(i, self.list.neighbours[k]);
            }
        }
        for ball in &mut self.balls[..self.free] {
            for wall in &self.region.walls {
                let depth = wall.overlap(ball) + SLACK * ball.radius;
                ball.x += wall.normal * depth.max(0.0);
            }
        }
        self.leave_parts();
        let leash = Leash::new(self.cells.skins(), self.cells.classes());
        let moved = self.balls.iter().zip(&self.reference);
        let squares = moved.map(|(ball, x)| (ball.x - x).norm_squared());
        if leash.is_due(f64::INFINITY, 0, squares) {
            self.list_neighbours();
        }
    }

    /// Takes spheres out of parts. A sphere with some clearance is searched again after it has
    /// moved by that.
    fn leave_parts(&mut self) {
        if self.region.parts.is_empty() {
            return;
        }
        for (ball, (seen, clear)) in self.balls[..self.free].iter_mut().zip(&mut self.clear) {
            if (ball.x - *seen).norm_squared() < *clear * *clear {
                continue;
            }
            let (depth, direction) = self.region.depth_in_parts(ball);
            let depth = depth + SLACK * ball.radius;
            ball.x += direction * depth.max(0.0);
            (*seen, *clear) = (ball.x, (-depth).max(0.0));
        }
    }

    /// Vector from body i to a neighbour of it.
    fn way(&self, i: usize, to: Neighbour) -> Vec3 {
        let shift = self.region.bounds.shifts[to.image as usize];
        self.balls[to.other as usize].x - self.balls[i].x + shift
    }

    fn push_apart(&mut self, i: usize, neighbour: Neighbour) {
        let (j, d) = (neighbour.other as usize, self.way(i, neighbour));
        let reach = (self.balls[i].radius + self.balls[j].radius) * (1.0 + SLACK);
        let square = d.norm_squared();
        if square >= reach * reach {
            return;
        }
        let distance = square.sqrt();
        // Two spheres in one place have no line of centres; any will do.
        let line = if distance > 0.0 { d / distance } else { Vec3::x() };
        let (share_i, share_j) = match (i < self.free, j < self.free) {
            (true, true) => (0.5, 0.5),
            (true, false) => (1.0, 0.0),
            _ => (0.0, 1.0),
        };
        let push = line * (reach - distance);
        self.balls[i].x -= push * share_i;
        self.balls[j].x += push * share_j;
    }

    /// Sweeps until no sphere of the packing overlaps anything; false when that takes more than
    /// `sweeps`.
    fn comes_free(&mut self, sweeps: usize) -> bool {
        (0..sweeps).any(|_| {
            self.sweep();
            self.is_free()
        })
    }

    fn is_out_of_parts(&self) -> bool {
        let mut spheres = self.balls[..self.free].iter().zip(&self.clear);
        self.region.parts.is_empty()
            || spheres.all(|(ball, (seen, clear))| {
                (ball.x - seen).norm_squared() < clear * clear
                    || self.region.depth_in_parts(ball).0 <= CLEAR * ball.radius
            })
    }

    fn shrink(&mut self) {
        for ball in &mut self.balls[..self.free] {
            ball.radius *= SHRINK;
        }
    }

    fn is_free(&self) -> bool {
        let balls = &self.balls;
        (0..balls.len()).all(|i| {
            self.list.row(i).all(|k| {
                let neighbour = self.list.neighbours[k];
                let other = &balls[neighbour.other as usize];
                let reach = (balls[i].radius + other.radius) * (1.0 - CLEAR);
                self.way(i, neighbour).norm_squared() >= reach * reach
            })
        }) && balls[..self.free].iter().all(|ball| {
            self.region.walls.iter().all(|wall| wall.overlap(ball) <= CLEAR * ball.radius)
        }) && self.is_out_of_parts()
    }
}
