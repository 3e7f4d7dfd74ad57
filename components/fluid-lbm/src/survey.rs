//! Sums and extremes over cells, taken while they collide.

use crate::collision::Flow;
use crate::field::Real;
use crate::lanes::Lanes;

/// Sums over the fluid cells of a block of lines, before their collision.
#[derive(Clone, Copy, Debug)]
pub struct Survey {
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

impl Survey {
    /// Of no cells.
    pub const NONE: Self = Self {
        excess: 0.0,
        j: [0.0; 3],
        speed2: 0.0,
        min_drho: f64::INFINITY,
        max_drho: f64::NEG_INFINITY,
        max_tau: 0.0,
    };

    /// Adds another block.
    pub fn join(&mut self, other: &Self) {
        self.excess += other.excess;
        for a in 0..3 {
            self.j[a] += other.j[a];
        }
        self.speed2 = self.speed2.max(other.speed2);
        self.min_drho = self.min_drho.min(other.min_drho);
        self.max_drho = self.max_drho.max(other.max_drho);
        self.max_tau = self.max_tau.max(other.max_tau);
    }
}

/// So many lines are added up in the numbers that they are kept in before they are added to sums in f64: to widen
/// numbers takes time, and a few of them are added up as well as each was computed.
const HELD: u32 = 4;

/// Running sums, one for each place of a 64-byte line, so that the order of additions is the same
/// for vectors of any length.
pub struct Sums<V: Lanes> {
    /// Density minus 1 and momentum of the last lines.
    held: [[V::Scalar; 16]; 4],
    /// How many lines these are.
    count: u32,
    /// The same of all lines before.
    sums: [[f64; 16]; 4],
    speed2: V,
    min_drho: V,
    max_drho: V,
    max_tau: V,
}

impl<V: Lanes> Sums<V> {
    /// Of no cells.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn new() -> Self {
        // SAFETY: by contract.
        let zero = unsafe { V::splat(0.0) };
        Self {
            held: [[V::Scalar::from_f64(0.0); 16]; 4],
            count: 0,
            sums: [[0.0; 16]; 4],
            speed2: zero,
            min_drho: zero,
            max_drho: zero,
            max_tau: zero,
        }
    }

    /// Adds the vector at lane `lane` of a line.
    #[inline(always)]
    pub fn add<const LES: bool>(&mut self, lane: usize, flow: &Flow<V>) {
        debug_assert!(lane + V::N <= 16);
        let [drho, x, y, z] = &mut self.held;
        let hold = |held: &mut [V::Scalar; 16], value: V| {
            let held = held.as_mut_ptr().wrapping_add(lane);
            // SAFETY: `lane` is a multiple of N, which divides LINE, so `lane + N <= LINE <= 16`.
            unsafe { (V::load(held) + value).store(held) };
        };
        hold(drho, flow.drho);
        hold(x, flow.j[0]);
        hold(y, flow.j[1]);
        hold(z, flow.j[2]);
        self.speed2 = flow.speed2.max(self.speed2);
        self.min_drho = flow.drho.min(self.min_drho);
        self.max_drho = flow.drho.max(self.max_drho);
        if LES {
            self.max_tau = flow.rates.tau.max(self.max_tau);
        }
    }

    /// Ends a line.
    #[inline(always)]
    pub fn end_line(&mut self) {
        self.count += 1;
        if self.count == HELD {
            self.widen();
        }
    }

    /// Adds the sums of the last lines to those of all before.
    #[inline(always)]
    fn widen(&mut self) {
        let mut k = 0;
        while k < 4 {
            let mut x = 0;
            while x < V::Scalar::LINE {
                let held = self.held[k].as_mut_ptr().wrapping_add(x);
                // SAFETY: both have room for a line, and the vectors that were added exist.
                unsafe {
                    V::load(held).add_to(self.sums[k].as_mut_ptr().add(x));
                    V::splat(0.0).store(held);
                }
                x += V::N;
            }
            k += 1;
        }
        self.count = 0;
    }

    /// Adds up the lanes, in their order.
    ///
    /// # Safety
    /// The processor has the variant's instructions.
    #[inline(always)]
    pub unsafe fn survey(&mut self) -> Survey {
        self.widen();
        let mut survey = Survey { min_drho: 0.0, max_drho: 0.0, ..Survey::NONE };
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
            self.speed2.store(lanes.as_mut_ptr());
            survey.speed2 = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
            self.min_drho.store(lanes.as_mut_ptr());
            survey.min_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().min(m));
            self.max_drho.store(lanes.as_mut_ptr());
            survey.max_drho = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
            self.max_tau.store(lanes.as_mut_ptr());
            survey.max_tau = lanes.iter().fold(0.0, |m, &x| x.to_f64().max(m));
        }
        survey
    }
}
