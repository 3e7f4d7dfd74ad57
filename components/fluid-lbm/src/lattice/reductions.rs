//! Sums and extremes over cells, taken while they collide.

use crate::lattice::collision::Moments;
use crate::lattice::exact_sum::ExactSum;
use crate::lattice::populations::LatticeVector;
use crate::lattice::populations::Real;
use serde::{Deserialize, Serialize};

/// Sums over the fluid cells of a block of lines, before their collision.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct CellStatistics {
    /// Sum of the densities minus 1.
    pub excess: f64,
    /// Sum of `h_i c_i` (without the half force of a step).
    pub j: [f64; 3],
    /// Largest `u.u`.
    pub speed2: f64,
    /// Smallest density minus 1.
    pub min_drho: f64,
    /// Largest density minus 1.
    pub max_drho: f64,
    /// Largest relaxation time of the closure; 0 without one.
    pub max_tau: f64,
}

impl CellStatistics {
    /// Of no cells.
    pub const NONE: Self = Self {
        excess: 0.0,
        j: [0.0; 3],
        speed2: 0.0,
        min_drho: f64::INFINITY,
        max_drho: f64::NEG_INFINITY,
        max_tau: 0.0,
    };

    /// Adds another piece of the same block.
    pub fn join(&mut self, other: &Self) {
        self.excess += other.excess;
        for a in 0..3 {
            self.j[a] += other.j[a];
        }
        self.join_extremes(other);
    }

    /// Takes over what is more extreme in others.
    fn join_extremes(&mut self, other: &Self) {
        self.speed2 = self.speed2.max(other.speed2);
        self.min_drho = self.min_drho.min(other.min_drho);
        self.max_drho = self.max_drho.max(other.max_drho);
        self.max_tau = self.max_tau.max(other.max_tau);
    }

    /// Those of blocks, which depend on no order of them.
    pub fn of_blocks<'b>(blocks: impl Iterator<Item = &'b Self>) -> ([ExactSum; 4], Self) {
        let (mut sums, mut all) = ([ExactSum::default(); 4], Self::NONE);
        for block in blocks {
            sums[0].add(block.excess);
            for a in 0..3 {
                sums[1 + a].add(block.j[a]);
            }
            all.join_extremes(block);
        }
        (sums, all)
    }
}

/// So many lines are added up in the numbers that they are kept in before they are added to sums in
/// f64: to widen numbers takes time, and a few of them are added up as well as each was computed.
const HELD: u32 = 4;

/// Running sums, one for each place of a 64-byte line, so that the order of additions is the same
/// for vectors of any length.
pub struct StatisticsSums<V> {
    /// Of the last lines, and extremes of all.
    held: Held<V>,
    /// Density minus 1 and momentum of all lines before.
    sums: [[f64; 16]; 4],
}

/// Vectors in a line at most.
const VECTORS: usize = 4;

/// Sums and extremes over a few lines. Small, so that a loop over lines keeps it in registers if
/// these hold whole lines.
#[derive(Clone, Copy)]
pub struct Held<V> {
    /// Density minus 1 and momentum, for each vector of a line.
    sums: [[V; VECTORS]; 4],
    /// Number of these lines.
    count: u32,
    v2: V,
    min_drho: V,
    max_drho: V,
    max_twice_tau: V,
}

impl<V: LatticeVector> Held<V> {
    /// The same without what no line has.
    #[inline(always)]
    fn lines(&self) -> Self {
        let mut own = Self { sums: [[self.v2; VECTORS]; 4], ..*self };
        let mut k = 0;
        while k < 4 {
            let mut vector = 0;
            while vector < V::Scalar::LINE / V::N {
                own.sums[k][vector] = self.sums[k][vector];
                vector += 1;
            }
            k += 1;
        }
        own
    }

    /// Adds the vector at lane `lane` of a line, whose cells have rates of their own or not.
    #[inline(always)]
    pub fn add(&mut self, lane: usize, flow: &Moments<V, impl Copy>, is_local: bool) {
        const { assert!(V::N * VECTORS >= V::Scalar::LINE) };
        // Of no effect; the compiler sees that the vector is there.
        let vector = (lane / V::N) % VECTORS;
        let [drho, x, y, z] = &mut self.sums;
        drho[vector] = drho[vector] + flow.drho;
        x[vector] = x[vector] + flow.j[0];
        y[vector] = y[vector] + flow.j[1];
        z[vector] = z[vector] + flow.j[2];
        self.v2 = flow.v2.max(self.v2);
        self.min_drho = flow.drho.min(self.min_drho);
        self.max_drho = flow.drho.max(self.max_drho);
        if is_local {
            self.max_twice_tau = flow.rates.twice_tau.max(self.max_twice_tau);
        }
    }
}

impl<V: LatticeVector> StatisticsSums<V> {
    /// Of no cells.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        // SAFETY: by contract.
        let zero = unsafe { V::splat(0.0) };
        Self {
            held: Held {
                sums: [[zero; VECTORS]; 4],
                count: 0,
                v2: zero,
                min_drho: zero,
                max_drho: zero,
                max_twice_tau: zero,
            },
            sums: [[0.0; 16]; 4],
        }
    }

    /// A copy of what is held, of which the compiler sees that nothing else changes it.
    #[inline(always)]
    pub fn held(&self) -> Held<V> {
        self.held.lines()
    }

    /// Puts it back.
    #[inline(always)]
    pub fn hold(&mut self, held: &Held<V>) {
        self.held.count = held.count;
        self.held.v2 = held.v2;
        self.held.min_drho = held.min_drho;
        self.held.max_drho = held.max_drho;
        self.held.max_twice_tau = held.max_twice_tau;
        let mut k = 0;
        while k < 4 {
            let mut vector = 0;
            while vector < V::Scalar::LINE / V::N {
                self.held.sums[k][vector] = held.sums[k][vector];
                vector += 1;
            }
            k += 1;
        }
    }

    /// Ends a line.
    #[inline(always)]
    pub fn end_line(&mut self, held: &mut Held<V>) {
        held.count += 1;
        if held.count == HELD {
            self.widen(held);
        }
    }

    /// Adds the sums of the last lines to those of all before.
    #[inline(always)]
    fn widen(&mut self, held: &mut Held<V>) {
        let mut k = 0;
        while k < 4 {
            let mut vector = 0;
            while vector < V::Scalar::LINE / V::N {
                // SAFETY: there is room for a line, and the vectors that were added exist.
                unsafe {
                    let to = self.sums[k].as_mut_ptr().add(vector * V::N);
                    held.sums[k][vector].add_to(to);
                    held.sums[k][vector] = V::splat(0.0);
                }
                vector += 1;
            }
            k += 1;
        }
        held.count = 0;
    }

    /// Adds up the lanes, in their order.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn survey(mut self) -> CellStatistics {
        let mut held = self.held;
        self.widen(&mut held);
        let mut survey = CellStatistics { min_drho: 0.0, max_drho: 0.0, ..CellStatistics::NONE };
        let mut k = 0;
        while k < V::Scalar::LINE {
            survey.excess += self.sums[0][k];
            survey.j[0] += self.sums[1][k];
            survey.j[1] += self.sums[2][k];
            survey.j[2] += self.sums[3][k];
            k += 1;
        }
        let mut lanes = [V::Scalar::from_f64(0.0); 16];
        // SAFETY: a vector has at most 16 lanes.
        unsafe {
            held.v2.store(lanes.as_mut_ptr());
            survey.speed2 = 4.0 / 9.0 * lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
            held.min_drho.store(lanes.as_mut_ptr());
            survey.min_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().min(m));
            held.max_drho.store(lanes.as_mut_ptr());
            survey.max_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
            held.max_twice_tau.store(lanes.as_mut_ptr());
            survey.max_tau = 0.5 * lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
        }
        survey
    }
}
