//! The equation of a cell with its neighbours along the axes, row by row.

use crate::grid::cell_rows::{CellRows, FillSpan};
use crate::grid::near_rows::NearRows;
use crate::grid::periodic_ghosts::PeriodicGhosts;
use crate::grid::staggered_grid::StaggeredGrid;
use nalgebra::{RealField, convert_unchecked};
use std::ops::Range;
use tremie_team::{Team, Variant};

/// Coefficients `diagonal q - sum over neighbours coupling q_beyond`. A cell that takes no part has
/// none, and its `q` is 0. What couples a cell to air, where `q` is 0, stands in its diagonal
/// alone.
#[derive(Clone, Debug)]
pub struct Stencil<T, const D: usize> {
    /// Of each cell.
    pub diagonal: Vec<T>,
    /// Of the lower face of each cell across each axis.
    pub coupling: [Vec<T>; D],
    /// Steps in memory along the axes.
    pub stride: [usize; D],
    /// Rows of cells that take part.
    pub rows: CellRows,
    /// Ghosts that stand for cells at the other end.
    pub ghosts: PeriodicGhosts,
}

/// Neighbours of a span of cells along all axes, and the couplings to them.
struct CellNeighbours<'a, T, const D: usize> {
    below: [&'a [T]; D],
    above: [&'a [T]; D],
    to_below: [&'a [T]; D],
    to_above: [&'a [T]; D],
    here: &'a [T],
    diagonal: &'a [T],
}

impl<'a, T: RealField + Copy, const D: usize> CellNeighbours<'a, T, D> {
    #[inline(always)]
    fn of(stencil: &'a Stencil<T, D>, q: &'a [T], start: usize, n: usize) -> Self {
        let stride = stencil.stride;
        let of = |array: &'a [T], begin: usize| &array[begin..begin + n];
        Self {
            below: std::array::from_fn(|a| of(q, start - stride[a])),
            above: std::array::from_fn(|a| of(q, start + stride[a])),
            to_below: std::array::from_fn(|a| of(&stencil.coupling[a], start)),
            to_above: std::array::from_fn(|a| of(&stencil.coupling[a], start + stride[a])),
            here: of(q, start),
            diagonal: of(&stencil.diagonal, start),
        }
    }

    /// The left side of the equation of cell `i` of the span.
    #[inline(always)]
    fn applied(&self, i: usize) -> T {
        let mut sum = self.diagonal[i] * self.here[i];
        for a in 0..D {
            sum -= self.to_below[a][i] * self.below[a][i];
            sum -= self.to_above[a][i] * self.above[a][i];
        }
        sum
    }
}

impl<T: RealField + Copy, const D: usize> Stencil<T, D> {
    /// Without any coefficients, of the cells of a grid.
    pub fn of_grid(grid: &StaggeredGrid<D>) -> Self {
        Self::empty(grid.stored, grid.stride, grid.ghosts.clone())
    }

    /// Without any coefficients.
    pub fn empty(stored: usize, stride: [usize; D], ghosts: PeriodicGhosts) -> Self {
        Self {
            diagonal: vec![T::zero(); stored],
            coupling: std::array::from_fn(|_| vec![T::zero(); stored]),
            stride,
            rows: CellRows::default(),
            ghosts,
        }
    }

    /// `A q` in one cell; ghosts of `q` have their values.
    #[inline]
    pub fn applied_at(&self, q: &[T], at: usize) -> T {
        let mut sum = self.diagonal[at] * q[at];
        for (coupling, stride) in self.coupling.iter().zip(self.stride) {
            sum -= coupling[at] * q[at - stride];
            sum -= coupling[at + stride] * q[at + stride];
        }
        sum
    }

    /// `A q` in one cell, in double precision; ghosts of `q` have their values.
    #[inline]
    pub fn applied_double(&self, q: &[f64], at: usize) -> f64 {
        let double = convert_unchecked::<T, f64>;
        let mut sum = double(self.diagonal[at]) * q[at];
        for (coupling, stride) in self.coupling.iter().zip(self.stride) {
            sum -= double(coupling[at]) * q[at - stride];
            sum -= double(coupling[at + stride]) * q[at + stride];
        }
        sum
    }

    /// Finds the rows of cells that have an equation; a row has `length` stored cells. Ghosts get
    /// the coefficients of the cells that they stand for, but no equation.
    pub fn find_rows(&mut self, length: usize) {
        let Self { diagonal, coupling, rows, ghosts, .. } = self;
        rows.rebuild(diagonal.len(), length, |at| diagonal[at] > T::zero());
        ghosts.fill(diagonal);
        coupling.iter_mut().for_each(|coupling| ghosts.fill(coupling));
    }

    /// The same, where all cells that have an equation are near; the others are not looked at.
    pub fn find_rows_near(&mut self, near: &NearRows, length: usize) {
        let Self { diagonal, coupling, rows, ghosts, .. } = self;
        let mut spans = near.spans().peekable();
        rows.rebuild_spans(diagonal.len(), length, |start| {
            let mut span = spans.next_if(|span| span.start < start + length)?;
            let has = |at: &usize| diagonal[*at] > T::zero();
            let first = span.clone().find(has)?;
            Some(first..span.rfind(has)? + 1)
        });
        ghosts.fill(diagonal);
        coupling.iter_mut().for_each(|coupling| ghosts.fill(coupling));
    }

    /// Writes to the cells of all rows what `value` says of them.
    #[inline(always)]
    fn each<V: CellValue<T, D, K>, const K: usize>(
        &self,
        team: &mut Team,
        variant: Variant,
        (q, others): (&mut [T], [&[T]; K]),
        out: &mut [T],
        value: V,
    ) {
        self.ghosts.fill(q);
        self.rows.fill(team, variant, out, &FillCells { stencil: self, q, others, value });
    }

    /// `out = A q`.
    pub fn apply(&self, team: &mut Team, variant: Variant, q: &mut [T], out: &mut [T]) {
        self.each(team, variant, (q, []), out, Applied);
    }

    /// `out = b - A q`.
    pub fn residual(&self, team: &mut Team, variant: Variant, q: &mut [T], b: &[T], out: &mut [T]) {
        self.each(team, variant, (q, [b]), out, Residual);
    }

    /// `out = r / diagonal`, and 0 where there is no equation.
    pub fn scale(&self, team: &mut Team, variant: Variant, r: &[T], out: &mut [T]) {
        self.rows.fill(team, variant, out, &Scaled { r, diagonal: &self.diagonal });
    }

    /// One step of Richardson's iteration, preconditioned by the diagonal: `out = q + weight
    /// (b - A q) / diagonal`. `inverse` holds the inverse of the diagonal, and 0 where there is no
    /// equation.
    #[expect(clippy::too_many_arguments, reason = "a formula of so many arrays")]
    pub fn relax(
        &self,
        team: &mut Team,
        variant: Variant,
        weight: T,
        inverse: &[T],
        q: &mut [T],
        b: &[T],
        out: &mut [T],
    ) {
        self.each(team, variant, (q, [b, inverse]), out, Relaxed { weight });
    }
}

/// The new value of a cell, from its neighbours and the values of `K` other arrays in it.
trait CellValue<T, const D: usize, const K: usize>: Sync {
    /// That of cell `i` of a span. It is to be inlined.
    fn at(&self, around: &CellNeighbours<T, D>, others: [&[T]; K], i: usize) -> T;
}

/// `A q`.
struct Applied;

impl<T: RealField + Copy, const D: usize> CellValue<T, D, 0> for Applied {
    #[inline(always)]
    fn at(&self, around: &CellNeighbours<T, D>, []: [&[T]; 0], i: usize) -> T {
        around.applied(i)
    }
}

/// `b - A q`.
struct Residual;

impl<T: RealField + Copy, const D: usize> CellValue<T, D, 1> for Residual {
    #[inline(always)]
    fn at(&self, around: &CellNeighbours<T, D>, [b]: [&[T]; 1], i: usize) -> T {
        b[i] - around.applied(i)
    }
}

/// A step of Richardson's iteration.
struct Relaxed<T> {
    weight: T,
}

impl<T: RealField + Copy, const D: usize> CellValue<T, D, 2> for Relaxed<T> {
    #[inline(always)]
    fn at(&self, around: &CellNeighbours<T, D>, [b, inverse]: [&[T]; 2], i: usize) -> T {
        around.here[i] + self.weight * inverse[i] * (b[i] - around.applied(i))
    }
}

/// `r / diagonal`.
struct Scaled<'a, T> {
    r: &'a [T],
    diagonal: &'a [T],
}

impl<T: RealField + Copy> FillSpan<T> for Scaled<'_, T> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [T]) {
        let (r, diagonal) = (&self.r[span.clone()], &self.diagonal[span.clone()]);
        for ((own, &r), &diagonal) in values.iter_mut().zip(r).zip(diagonal) {
            *own = if diagonal > T::zero() { r / diagonal } else { T::zero() };
        }
    }
}

/// The cells of spans, and what their values follow from.
struct FillCells<'a, T, V, const D: usize, const K: usize> {
    stencil: &'a Stencil<T, D>,
    q: &'a [T],
    others: [&'a [T]; K],
    value: V,
}

impl<T, V, const D: usize, const K: usize> FillSpan<T> for FillCells<'_, T, V, D, K>
where
    T: RealField + Copy,
    V: CellValue<T, D, K>,
{
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [T]) {
        let n = values.len();
        let around = CellNeighbours::of(self.stencil, self.q, span.start, n);
        let others = self.others.map(|array| &array[span.start..span.start + n]);
        for i in 0..n {
            values[i] = self.value.at(&around, others, i);
        }
    }
}
