//! Populations for cells that a body uncovered.
//!
//! `f_i(x_n) = feq_i(rho_n, u_w) + [f_i - feq_i](x_d)`: the density is the mean over the neighbours
//! that were fluid before, the velocity that of the body's surface (no slip), and the viscous
//! stress that of the neighbour `x_d` in the direction closest to the outward normal. Extrapolating
//! densities instead would amplify noise in narrow gaps, where only one neighbour exists.

use crate::bodies::body::Body;
use crate::lattice::aa_pattern::Parity;
use crate::lattice::cell_flags::CellFlags;
use crate::lattice::d3q19::{C, C_F64, Q, dot, equilibria, mirrored, moments};
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::layout::Layout;
use crate::lattice::populations::{Field, Real};

/// The fluid as it is before a collision.
#[derive(Clone, Copy)]
pub struct PreCollision<'a, T: Real> {
    /// Populations.
    pub field: &'a Field<T>,
    /// Layout of the cells, with the places of their populations.
    pub layout: &'a Layout,
    /// Parity of the collision to come.
    pub parity: Parity,
    /// Acceleration of the fluid.
    pub acceleration: [f64; 3],
}

/// Cells of the longest line.
pub const MOST_LANES: usize = 16;

/// Density minus 1 and momentum `sum_i h_i c_i` of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Content {
    /// Density minus 1.
    pub drho: f64,
    /// Momentum without half the force of a step.
    pub j: [f64; 3],
}

impl Content {
    /// Of populations.
    #[inline]
    pub fn of(h: &[f64; Q]) -> Self {
        let (drho, j) = moments(h);
        Self { drho, j }
    }

    /// Velocity, with half the step's force: `j/rho + a/2`.
    pub fn velocity(&self, acceleration: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.j[a] / (1.0 + self.drho) + 0.5 * acceleration[a])
    }
}

/// Fluid in the least cube around a cell that has some: so it is in the cube's outer layer.
#[derive(Clone, Copy, Debug)]
pub struct NearestFluid {
    /// Cells from the middle of the cube to its faces.
    pub reach: i32,
    /// Sum of the densities minus 1, and number of the cells.
    pub drho: ExactSum,
    /// See there.
    pub count: i64,
}

impl NearestFluid {
    /// Mean of the density minus 1.
    pub fn mean(&self) -> f64 {
        self.drho.value() / self.count as f64
    }

    /// Adds what another rank found for the same cell.
    pub fn join(&mut self, other: &Self) {
        match self.reach.cmp(&other.reach) {
            std::cmp::Ordering::Less => {}
            std::cmp::Ordering::Greater => *self = *other,
            std::cmp::Ordering::Equal => {
                self.drho += other.drho;
                self.count += other.count;
            }
        }
    }
}

impl<T: Real> PreCollision<'_, T> {
    /// Populations that the collision will find in a cell.
    #[inline(always)]
    pub fn populations(&self, cell: u32) -> [f64; Q] {
        self.layout.populations(self.field, self.parity, cell)
    }

    /// Writes them.
    pub fn put(&self, cell: u32, h: &[f64; Q]) {
        for (place, &h) in self.layout.places.of_cell(self.parity, cell).into_iter().zip(h) {
            self.field.set(place, h);
        }
    }

    /// Density minus 1 and momentum of a cell.
    pub fn content(&self, cell: u32) -> Content {
        Content::of(&self.populations(cell))
    }

    /// The same of the first `lanes` cells of a line.
    pub fn contents(&self, line: usize, lanes: usize) -> [Content; MOST_LANES] {
        let first = (line * T::LINE) as u32;
        let (mut drho, mut j) = ([0.0; MOST_LANES], [[0.0; MOST_LANES]; 3]);
        for i in 0..Q {
            let mut h = [0.0; MOST_LANES];
            match self.layout.places.of_line(self.parity, line, i) {
                Some(place) => h.iter_mut().zip(self.field.line(place)).for_each(|(h, f)| *h = f),
                None => {
                    for (lane, h) in h[..lanes].iter_mut().enumerate() {
                        let place = self.layout.place(self.parity, first + lane as u32, i);
                        *h = self.field.get(place);
                    }
                }
            }
            for lane in 0..T::LINE {
                drho[lane] += h[lane];
            }
            for a in (0..3).filter(|&a| C[i][a] != 0) {
                for lane in 0..T::LINE {
                    j[a][lane] += h[lane] * C_F64[i][a];
                }
            }
        }
        std::array::from_fn(|lane| Content { drho: drho[lane], j: j.map(|j| j[lane]) })
    }

    /// Fills a cell that `body` uncovered with a density `1 + drho`, see [`PreCollision::mean_near`]. Returns what the
    /// cell now holds.
    pub fn refill(&self, flags: &CellFlags, cell: u32, body: &Body, drho: f64) -> Content {
        let arm = self.layout.grid.arm(body.position, self.layout.at(cell));
        let mut h = equilibria(drho, body.velocity_of(body.hit_near(arm), arm));
        if let Some(of_donor) = self.donor(flags, cell, body.outward(arm)) {
            let content = Content::of(&of_donor);
            let u = content.velocity(self.acceleration);
            let of_equilibrium = equilibria(content.drho, u);
            for i in 0..Q {
                h[i] += of_donor[i] - of_equilibrium[i];
            }
        }
        self.put(cell, &h);
        self.content(cell)
    }

    /// Mean deviation of the density over the fluid cells among the lattice neighbours of a cell. `None` if there are
    /// none: for those see `far_means`.
    pub fn mean_near(&self, flags: &CellFlags, cell: u32) -> Option<f64> {
        let is_fluid = |neighbour: u32| neighbour != cell && flags.is_fluid(neighbour);
        let mut count = 0;
        // All places first: memory is slower than anything here.
        let mut places = [[0; Q]; Q];
        for neighbour in (1..Q).filter_map(|i| self.layout.neighbour(cell, i)) {
            if is_fluid(neighbour) {
                places[count] = self.layout.places.of_cell(self.parity, neighbour);
                places[count].iter().for_each(|&place| self.field.prefetch(place));
                count += 1;
            }
        }
        let sum: f64 = places[..count].iter().flatten().map(|&place| self.field.get(place)).sum();
        (count > 0).then(|| sum / count as f64)
    }

    /// The fluid that this rank counts in the outer layer of the cube of cells up to `reach` away from one at `at`, if
    /// there is some.
    pub fn fluid_at(&self, flags: &CellFlags, at: [i32; 3], reach: i32) -> Option<NearestFluid> {
        let mut found = NearestFluid { reach, drho: ExactSum::default(), count: 0 };
        let mut look = |d: [i32; 3]| {
            if let Some((cell, _)) = self.layout.near(at, d)
                && flags.is_fluid(cell)
                && self.layout.is_own(cell)
            {
                found.drho.add(self.populations(cell).iter().sum());
                found.count += 1;
            }
        };
        for z in -reach..=reach {
            for y in -reach..=reach {
                let is_face = z.abs() == reach || y.abs() == reach;
                let step = if is_face { 1 } else { 2 * reach as usize };
                (-reach..=reach).step_by(step).for_each(|x| look([x, y, z]));
            }
        }
        (found.count > 0).then_some(found)
    }

    /// Populations of the neighbour in the direction closest to `normal`, if it is fluid; mirrored,
    /// if it is seen in a mirror.
    fn donor(&self, flags: &CellFlags, cell: u32, normal: [f64; 3]) -> Option<[f64; Q]> {
        let (mut best, mut cosine) = (None, 0.0);
        for i in 1..Q {
            let c = dot(C_F64[i], normal) / dot(C_F64[i], C_F64[i]).sqrt();
            if c > cosine {
                (best, cosine) = (Some(i), c);
            }
        }
        let best = best?;
        let donor = self.layout.neighbour(cell, best)?;
        if donor == cell || !flags.is_fluid(donor) {
            return None;
        }
        let (_, mirrors) = self.layout.near(self.layout.at(cell), C[best])?;
        let h = self.populations(donor);
        Some(std::array::from_fn(|i| h[mirrored(i, mirrors)]))
    }
}
