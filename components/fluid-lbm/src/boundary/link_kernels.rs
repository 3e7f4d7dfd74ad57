//! Arithmetic of a batch of links, eight at a time: where they meet the body, what that means for
//! populations, and sums. See `post_collision` for the formulae.
//!
//! Written once for plain arrays and compiled for each set of vector instructions; no operation
//! here is fused or reordered, so that every variant yields the same bits. Sums run in eight lanes, and depend
//! on no order.

use crate::bodies::body::late;
use crate::boundary::bouzidi::Bouzidi;
use crate::lattice::d3q19::W;
use crate::lattice::exact_sum::{ExactSum, binned};
use crate::lattice::momentum_exchange::LinkExchange;
use std::sync::atomic::{Ordering::SeqCst, compiler_fence};
use tremie_team::instructions::Work;

/// Links that are done together.
pub const LANES: usize = 8;

/// A number of each of eight links.
pub type Lane = [f64; LANES];

/// Eight links, in columns.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct LinkBlock {
    /// From the body's centre to the cell's; then to where the link meets the surface.
    pub arm: [Lane; 3],
    /// Direction as seen by the body.
    pub c: [Lane; 3],
    /// Squared length of `c`.
    pub cc: Lane,
    /// Wall distance, as part of the link's length; found here for a sphere.
    pub q: Lane,
    /// Weight of the direction, times 6.
    pub weight: Lane,
    /// Factor of `g_i`.
    pub own: Lane,
    /// Factor of the other population.
    pub other: Lane,
    /// Population that the wall's motion takes at density 1.
    pub push: Lane,
    /// Velocity of the wall.
    pub u: [Lane; 3],
    /// `g_i + f_i'`.
    pub sum: Lane,
    /// `f_i' - g_i`.
    pub gain: Lane,
    /// 1 of a link whose cell this part of the lattice counts, else 0.
    pub own_cell: Lane,
}

impl LinkBlock {
    /// Links of no direction.
    pub const NONE: Self = Self {
        arm: [[0.0; LANES]; 3],
        c: [[0.0; LANES]; 3],
        cc: [1.0; LANES],
        q: [0.5; LANES],
        weight: [0.0; LANES],
        own: [0.0; LANES],
        other: [0.0; LANES],
        push: [0.0; LANES],
        u: [[0.0; LANES]; 3],
        sum: [0.0; LANES],
        gain: [0.0; LANES],
        own_cell: [1.0; LANES],
    };
}

/// Eight links of a sphere, as they stand on the lattice.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// From the first cell around the sphere to the cell where each begins.
    pub at: [[i16; LANES]; 3],
    /// Direction as seen by the body.
    pub c: [[i8; LANES]; 3],
}

impl Standing {
    /// Links that are to come.
    pub const NONE: Self = Self { at: [[0; LANES]; 3], c: [[0; LANES]; 3] };
}

/// Weights of directions along one axis and along two, times 6.
const STRAIGHT: f64 = 6.0 * W[1];
const ASLANT: f64 = 6.0 * W[7];

/// Properties of a body that its links need.
#[derive(Clone, Copy, Debug)]
pub struct Surface {
    /// Squared radius of a sphere.
    pub r2: Option<f64>,
    /// Velocity.
    pub velocity: [f64; 3],
    /// Angular velocity.
    pub spin: [f64; 3],
    /// By how much the velocity changes in a step, see [`late`].
    pub change: [f64; 3],
    /// Walls nearer than this count as that near, see
    /// [`crate::boundary::post_collision::nearest_wall`].
    pub nearest: f64,
}

/// Numbers of each of eight links, added up by place without any rounding, so that the sum depends on no order; see
/// [`binned`].
#[derive(Clone, Copy, Debug)]
pub struct LaneSums<const N: usize> {
    coarse: [Lane; N],
    fine: [Lane; N],
}

impl<const N: usize> LaneSums<N> {
    /// Of no links.
    pub const NONE: Self = Self { coarse: [[0.0; LANES]; N], fine: [[0.0; LANES]; N] };

    /// Adds a number of the link in a lane.
    #[inline(always)]
    fn add(&mut self, place: usize, lane: usize, x: f64) {
        let [coarse, fine] = binned(x);
        self.coarse[place][lane] += coarse;
        self.fine[place][lane] += fine;
    }

    /// The sum in a place over all lanes.
    pub fn total(&self, place: usize) -> ExactSum {
        // Multiples of a quantum, which a number of 53 bits holds: exact, too.
        let all = |lanes: &Lane| lanes.iter().fold(0.0, |sum, x| sum + x);
        let mut total = ExactSum::of(all(&self.coarse[place]));
        total.add(all(&self.fine[place]));
        total
    }
}

/// Sums over links: force, torque, `gain u`, and `gain`.
pub type ExchangeSums = LaneSums<10>;

/// Sums over links: volume by which the wall receded, and weights.
pub type Paid = LaneSums<2>;

/// Puts links where they stand around a body.
pub struct PlaceLinks<'a> {
    /// Positions of the links on the lattice.
    pub standing: &'a [Standing],
    /// The first cell around the body.
    pub origin: [i32; 3],
    /// Position of the body.
    pub position: [f64; 3],
    /// Get their arms, directions and weights.
    pub links: &'a mut [LinkBlock],
}

impl Work for PlaceLinks<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { standing, origin, position, links } = self;
        for (standing, eight) in standing.iter().zip(links) {
            // Copied first: else compilers fear that a number written changes the next one read.
            let Standing { at, c } = *standing;
            let mut cc = [0.0; LANES];
            for a in 0..3 {
                let (at, c) = (at[a], c[a]);
                for k in 0..LANES {
                    eight.arm[a][k] = f64::from(origin[a] + i32::from(at[k])) + 0.5 - position[a];
                }
                for k in 0..LANES {
                    let c = f64::from(c[k]);
                    eight.c[a][k] = c;
                    cc[k] += c * c;
                }
            }
            eight.cc = cc;
            for k in 0..LANES {
                eight.weight[k] = if cc[k] > 1.0 { ASLANT } else { STRAIGHT };
            }
            // Else compilers fill vectors with the same lane of eight eights, one number at a time.
            compiler_fence(SeqCst);
        }
    }
}

/// Finds where links meet the body and what follows from that.
pub struct InterpolateBouzidi<'a> {
    /// Links that stand around it.
    pub links: &'a mut [LinkBlock],
    /// The body.
    pub body: Surface,
}

impl Work for InterpolateBouzidi<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { links, body } = self;
        for eight in links {
            if let Some(r2) = body.r2 {
                meet_sphere(eight, r2);
            }
            let (v, w, change) = (body.velocity, body.spin, body.change);
            for k in 0..LANES {
                let d = [eight.arm[0][k], eight.arm[1][k], eight.arm[2][k]];
                let c = [eight.c[0][k], eight.c[1][k], eight.c[2][k]];
                let q = eight.q[k];
                let wall = [d[0] + q * c[0], d[1] + q * c[1], d[2] + q * c[2]];
                let u = [
                    v[0] + (w[1] * wall[2] - w[2] * wall[1]),
                    v[1] + (w[2] * wall[0] - w[0] * wall[2]),
                    v[2] + (w[0] * wall[1] - w[1] * wall[0]),
                ];
                // The bound is for the interpolation alone: torque and velocity are those of the
                // true place.
                let q = q.max(body.nearest);
                let later = late(q) * (c[0] * change[0] + c[1] * change[1] + c[2] * change[2]);
                let push = eight.weight[k] * (c[0] * u[0] + c[1] * u[1] + c[2] * u[2] + later);
                let bouzidi = Bouzidi::at(q);
                eight.own[k] = bouzidi.own;
                eight.other[k] = bouzidi.other;
                eight.push[k] = bouzidi.push * push;
                for a in 0..3 {
                    eight.arm[a][k] = wall[a];
                    eight.u[a][k] = u[a];
                }
            }
        }
    }
}

/// As `sphere_raster::wall_distance`, in the same order of operations.
#[inline(always)]
fn meet_sphere(eight: &mut LinkBlock, r2: f64) {
    for k in 0..LANES {
        let d = [eight.arm[0][k], eight.arm[1][k], eight.arm[2][k]];
        let c = [eight.c[0][k], eight.c[1][k], eight.c[2][k]];
        let b = d[0] * c[0] + d[1] * c[1] + d[2] * c[2];
        let gap = (d[0] * d[0] + (d[1] * d[1] + d[2] * d[2])) - r2;
        let root = (b * b - eight.cc[k] * gap).max(0.0).sqrt();
        eight.q[k] = (gap / (root - b)).clamp(f64::MIN_POSITIVE, 1.0);
    }
}

/// Adds what bodies pay to what their motion pushes, and up by how much their walls recede; see
/// `mass_correction`.
pub struct CorrectMass<'a> {
    /// Links that are located.
    pub links: &'a mut [LinkBlock],
    /// Mass that the body pays, for each unit of `6 w_i`.
    pub rate: f64,
    /// Sums to which the volume by which walls recede is added, and the weights.
    pub sums: &'a mut Paid,
}

impl Work for CorrectMass<'_> {
    #[inline(always)]
    fn run(self) {
        let mut own = *self.sums;
        for eight in self.links {
            for k in 0..LANES {
                let [cx, cy, cz] = [eight.c[0][k], eight.c[1][k], eight.c[2][k]];
                let along = cx * eight.u[0][k] + cy * eight.u[1][k] + cz * eight.u[2][k];
                let counted = eight.weight[k] * eight.own_cell[k];
                own.add(0, k, counted * along);
                own.add(1, k, counted);
                eight.push[k] -= self.rate * eight.weight[k];
            }
        }
        *self.sums = own;
    }
}

/// Adds what links exchanged to sums.
pub struct SumMomentumExchange<'a> {
    /// Links that are reflected.
    pub links: &'a [LinkBlock],
    /// Grow by what they exchanged.
    pub sums: &'a mut ExchangeSums,
}

impl Work for SumMomentumExchange<'_> {
    #[inline(always)]
    fn run(self) {
        let mut own = *self.sums;
        for eight in self.links {
            for k in 0..LANES {
                let arm = [eight.arm[0][k], eight.arm[1][k], eight.arm[2][k]];
                let c = [eight.c[0][k], eight.c[1][k], eight.c[2][k]];
                let u = [eight.u[0][k], eight.u[1][k], eight.u[2][k]];
                let gain = eight.gain[k];
                let link = LinkExchange::of(c, eight.sum[k], gain, u, arm);
                for a in 0..3 {
                    own.add(a, k, link.force[a]);
                    own.add(3 + a, k, link.torque[a]);
                    own.add(6 + a, k, link.swept[a]);
                }
                own.add(9, k, gain);
            }
        }
        *self.sums = own;
    }
}
