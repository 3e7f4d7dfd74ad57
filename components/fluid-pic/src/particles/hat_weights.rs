//! Bilinear and trilinear weights of the values around a point: the hat of width `h`, which keeps
//! mass and momentum.

use crate::grid::staggered_grid::{GHOST, StaggeredGrid};

/// Most values around a point.
pub(crate) const MOST: usize = 8;

/// Values around a point: the place of the lowest, and the point's shares along each axis.
#[derive(Clone, Copy, Debug)]
pub struct HatWeights<const D: usize> {
    /// Place in memory of the lowest of the `2^D` values.
    pub base: usize,
    /// Share of the upper value along each axis.
    pub upper: [f64; D],
}

impl<const D: usize> HatWeights<D> {
    /// Of values at cell centres, or on the lower faces across an axis.
    #[inline(always)]
    pub fn new(grid: &StaggeredGrid<D>, face: Option<usize>, point: [f64; D]) -> Self {
        let mut base = 0;
        let mut upper = [0.0; D];
        let inverse = 1.0 / grid.spacing;
        for a in 0..D {
            let shift = if face == Some(a) { 0.0 } else { 0.5 };
            let along = (point[a] - grid.origin[a]) * inverse + (GHOST as f64 - shift);
            // Points never lie beyond the ghosts; the clamp keeps a wrong one from reading
            // elsewhere.
            let below = (along as usize).min(grid.cells[a]);
            base += below * grid.stride[a];
            upper[a] = (along - below as f64).clamp(0.0, 1.0);
        }
        Self { base, upper }
    }

    /// Steps in memory from the lowest value to each of the `2^D`, of which the first are used.
    #[inline(always)]
    pub(crate) fn steps(grid: &StaggeredGrid<D>) -> [usize; MOST] {
        let mut steps = [0; MOST];
        for a in 0..D {
            for corner in 0..1 << a {
                steps[corner + (1 << a)] = steps[corner] + grid.stride[a];
            }
        }
        steps
    }

    /// Place and weight of each of the `2^D` values.
    #[inline(always)]
    pub fn each(&self, grid: &StaggeredGrid<D>, mut f: impl FnMut(usize, f64)) {
        let steps = Self::steps(grid);
        let mut weights = [1.0; MOST];
        for a in 0..D {
            for corner in 0..1 << a {
                weights[corner + (1 << a)] = weights[corner] * self.upper[a];
                weights[corner] *= 1.0 - self.upper[a];
            }
        }
        for corner in 0..1 << D {
            f(self.base + steps[corner], weights[corner]);
        }
    }

    /// Place of the lower value, and weight, of each pair of values along the first axis; of the
    /// `2^(D-1)` the first are used.
    #[inline(always)]
    pub fn pairs(&self, grid: &StaggeredGrid<D>) -> [(usize, f64); MOST / 2] {
        let mut pairs = [(self.base, 1.0); MOST / 2];
        for a in 1..D {
            let half = 1 << (a - 1);
            for pair in 0..half {
                let (place, weight) = pairs[pair];
                pairs[pair + half] = (place + grid.stride[a], weight * self.upper[a]);
                pairs[pair].1 *= 1.0 - self.upper[a];
            }
        }
        pairs
    }

    /// Several values that lie side by side, interpolated.
    #[inline(always)]
    pub fn values<const N: usize>(&self, grid: &StaggeredGrid<D>, values: &[[f64; N]]) -> [f64; N] {
        let steps = Self::steps(grid);
        let mut around = [[0.0; N]; MOST];
        for corner in 0..1 << D {
            around[corner] = values[self.base + steps[corner]];
        }
        for a in (0..D).rev() {
            for corner in 0..1 << a {
                let beyond = around[corner + (1 << a)];
                for (own, beyond) in around[corner].iter_mut().zip(beyond) {
                    *own += self.upper[a] * (beyond - *own);
                }
            }
        }
        around[0]
    }

    /// The gradient of the interpolation along each axis.
    #[inline(always)]
    pub fn gradient(&self, grid: &StaggeredGrid<D>, values: &[f64]) -> [f64; D] {
        let mut sum = [0.0; D];
        for corner in 0..1 << D {
            let mut place = self.base;
            for a in 0..D {
                place += if corner >> a & 1 == 1 { grid.stride[a] } else { 0 };
            }
            for k in 0..D {
                let mut weight = 1.0 / grid.spacing;
                for a in 0..D {
                    let is_upper = corner >> a & 1 == 1;
                    weight *= match (a == k, is_upper) {
                        (true, true) => 1.0,
                        (true, false) => -1.0,
                        (false, true) => self.upper[a],
                        (false, false) => 1.0 - self.upper[a],
                    };
                }
                sum[k] += weight * values[place];
            }
        }
        sum
    }
}
