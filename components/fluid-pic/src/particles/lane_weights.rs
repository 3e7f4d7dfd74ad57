//! Weights of the values around points side by side: [`HatWeights`] of several points at once.

use crate::grid::staggered_grid::{GHOST, StaggeredGrid};
use crate::particles::hat_weights::{HatWeights, MOST};
use tremie_team::{Places, SimdGather};

/// Values around points side by side.
#[derive(Clone, Copy, Debug)]
pub struct LaneWeights<V, const D: usize> {
    /// Places in memory of the lowest of the `2^D` values; none is beyond the grid, whatever the
    /// points.
    base: Places,
    /// Shares of the upper value along each axis.
    upper: [V; D],
}

/// [`HatWeights`] of up to eight points.
#[derive(Clone, Copy, Debug)]
pub struct SideBySide<const D: usize> {
    base: Places,
    upper: [[f64; 8]; D],
}

impl<const D: usize> SideBySide<D> {
    /// Of one of the points.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> HatWeights<D> {
        let mut upper = [0.0; D];
        for a in 0..D {
            upper[a] = self.upper[a][lane];
        }
        HatWeights { base: self.base[lane] as usize, upper }
    }
}

/// Some of the coordinates from one on along each axis. Lanes beyond the last one follow the first.
///
/// # Safety
/// The processor has the instructions of `V`.
#[inline(always)]
pub unsafe fn load_points<V: SimdGather, const D: usize>(
    along: [&[f64]; D],
    first: usize,
    count: usize,
) -> [V; D] {
    // SAFETY: by contract.
    let mut points = [unsafe { V::splat(0.0) }; D];
    for a in 0..D {
        let own = &along[a][first..first + count];
        points[a] = if count == V::N {
            // SAFETY: by contract, and there are so many.
            unsafe { V::load(own.as_ptr()) }
        } else {
            let mut padded = [own[0]; 8];
            padded[..count].copy_from_slice(own);
            // SAFETY: by contract; no vector has more than eight lanes.
            unsafe { V::load(padded.as_ptr()) }
        };
    }
    points
}

impl<V: SimdGather, const D: usize> LaneWeights<V, D> {
    /// Of values at cell centres, or on the lower faces across an axis.
    ///
    /// # Safety
    /// The processor has the instructions of `V`.
    #[inline(always)]
    pub unsafe fn new(grid: &StaggeredGrid<D>, face: Option<usize>, point: [V; D]) -> Self {
        // SAFETY: by contract.
        let [zero, one, inverse] =
            unsafe { [V::splat(0.0), V::splat(1.0), V::splat(1.0 / grid.spacing)] };
        let (mut place, mut upper) = (zero, [zero; D]);
        for a in 0..D {
            let shift = if face == Some(a) { 0.0 } else { 0.5 };
            let ghosts = zero.all(GHOST as f64 - shift);
            let along = (point[a] - zero.all(grid.origin[a])) * inverse + ghosts;
            // The bounds keep a point that is beyond the ghosts, or no number, from reading
            // elsewhere.
            let below = along.max(zero).min(zero.all(grid.cells[a] as f64)).truncated();
            place = place + below * zero.all(grid.stride[a] as f64);
            upper[a] = (along - below).max(zero).min(one);
        }
        Self { base: place.places(), upper }
    }

    /// The weights, one point after the other.
    #[inline(always)]
    pub fn one_by_one(&self) -> SideBySide<D> {
        let mut upper = [[0.0; 8]; D];
        for a in 0..D {
            // SAFETY: no vector has more than eight lanes.
            unsafe { self.upper[a].store(upper[a].as_mut_ptr()) };
        }
        SideBySide { base: self.base, upper }
    }

    /// The interpolated values.
    ///
    /// # Panics
    /// If the values are not the grid's.
    #[inline(always)]
    pub fn value(&self, grid: &StaggeredGrid<D>, values: &[f64]) -> V {
        assert!(values.len() == grid.stored && grid.stored < 1 << 31, "values of the grid");
        let steps = HatWeights::steps(grid);
        let mut around = [self.upper[0]; MOST];
        for corner in 0..1 << D {
            // SAFETY: places are those of cells in the box or of its lower ghosts, and the ghosts
            // above them are in the grid. The shares exist, so the instructions do.
            around[corner] = unsafe { V::gathered(&self.base, values.as_ptr().add(steps[corner])) };
        }
        for a in (0..D).rev() {
            for corner in 0..1 << a {
                let beyond = around[corner + (1 << a)] - around[corner];
                around[corner] = around[corner] + self.upper[a] * beyond;
            }
        }
        around[0]
    }
}
