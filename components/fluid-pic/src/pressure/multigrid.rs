//! A V-cycle of geometric multigrid, as a preconditioner: symmetric, and linear in its right side.
//!
//! Cells are smoothed by two steps of Richardson's iteration with Chebyshev's weights,
//! preconditioned by the diagonal; all cells at once, so that results do not depend on the order of
//! work. The transpose of the interpolation ([`Interpolation`]) sums what is left.

use crate::grid::cell_rows::FillSpan;
use crate::grid::near_rows::NearRows;
use crate::pressure::body_coupling::{BodyCoupling, dot6};
use crate::pressure::coarsen::{LevelShape, coarsen, held_by_air};
use crate::pressure::interpolation::Interpolation;
use crate::pressure::light_bodies::{LIGHT, LightBodies};
use crate::pressure::stencil::Stencil;
use nalgebra::{Cholesky, DMatrix, Dyn};
use std::ops::Range;
use tremie_team::{Team, Variant};

/// Cells that take part up to which a level is solved directly.
const DIRECT: usize = 160;
/// Regularisation of the directly solved level, relative: without air its solution is free up to a
/// constant.
const REGULAR: f64 = 1e-4;
/// Volume of a body in cells from which a level resolves it, by the number of dimensions less one.
/// Found by trial: with less the iterations on grids of 40 to 80 cells along each axis triple.
const RESOLVED: [f64; 3] = [1.0, 1.0, 8.0];

/// One level of the grids.
struct Level<const D: usize> {
    shape: LevelShape<D>,
    /// Axes whose ends join, but across which nothing is interpolated to the finer level.
    is_seam: [bool; D],
    interpolation: Interpolation<D>,
    stencil: Stencil<f32, D>,
    coupling: BodyCoupling,
    light: LightBodies,
    /// Inverse of the diagonal, with what bodies add to it; 0 where there is no equation.
    inverse: Vec<f32>,
    /// What couples a cell to air, over the number of its neighbours that are no fluid.
    held: Vec<f32>,
    /// Coupling of an open face across each axis.
    full: [f32; D],
    /// Slopes of the interpolation across the lower face of each cell, along each axis.
    slope: [Vec<f32>; D],
    q: Vec<f32>,
    b: Vec<f32>,
    rest: Vec<f32>,
}

/// Richardson's first step from zero: `weight b / diagonal`.
struct FirstStep<'a> {
    weight: f32,
    inverse: &'a [f32],
    b: &'a [f32],
}

impl FillSpan<f32> for FirstStep<'_> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [f32]) {
        let (b, inverse) = (&self.b[span.clone()], &self.inverse[span.clone()]);
        for ((own, b), inverse) in values.iter_mut().zip(b).zip(inverse) {
            *own = self.weight * inverse * b;
        }
    }
}

/// Numbers in single precision.
struct Single<'a>(&'a [f64]);

impl FillSpan<f32> for Single<'_> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [f32]) {
        values.iter_mut().zip(&self.0[span.clone()]).for_each(|(own, &other)| *own = other as f32);
    }
}

/// Numbers in double precision.
struct Double<'a>(&'a [f32]);

impl FillSpan<f64> for Double<'_> {
    #[inline(always)]
    fn fill(&self, span: &Range<usize>, values: &mut [f64]) {
        for (own, &other) in values.iter_mut().zip(&self.0[span.clone()]) {
            *own = f64::from(other);
        }
    }
}

/// The hierarchy of grids.
pub struct Multigrid<const D: usize> {
    levels: Vec<Level<D>>,
    /// Levels in use: at the last of them the equation is solved directly.
    used: usize,
    direct: Option<Cholesky<f64, Dyn>>,
    /// Places of the unknowns of the direct solution.
    unknowns: Vec<u32>,
    weights: [f32; 2],
}

/// Weights of two steps that damp the modes between `low` and `high` eigenvalues best.
fn chebyshev(low: f64, high: f64) -> [f32; 2] {
    let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
    let cosine = std::f64::consts::FRAC_1_SQRT_2;
    [1.0 / (middle + half * cosine), 1.0 / (middle - half * cosine)].map(|w| w as f32)
}

impl<const D: usize> Multigrid<D> {
    /// Of a grid of so many cells along each axis, some of which wrap around.
    pub fn new(cells: [usize; D], periodic: [bool; D]) -> Self {
        let mut shapes = vec![LevelShape::new(cells, periodic)];
        while let Some(last) = shapes.last()
            && last.cells.iter().product::<usize>() > 8
            && shapes.len() < 24
        {
            shapes.push(last.coarser());
        }
        // Rough modes have eigenvalues of the scaled equation from 2 / D / 2 on, up to 2.
        let low = 1.0 / D as f64;
        let seams = |k: usize| {
            let finer = k.checked_sub(1).map(|finer| &shapes[finer]);
            std::array::from_fn(|a| finer.is_some_and(|shape| shape.has_seam(a)))
        };
        Self {
            levels: (0..shapes.len()).map(|k| Level::new(shapes[k], seams(k))).collect(),
            used: 1,
            direct: None,
            unknowns: Vec::new(),
            weights: chebyshev(low, 2.0),
        }
    }

    /// Takes over the coefficients of the finest level, of whose cells only those near count.
    pub fn prepare(&mut self, finest: &Stencil<f64, D>, near: &NearRows, coupling: &BodyCoupling) {
        let level = &mut self.levels[0];
        let to_single = |from: &[f64], to: &mut [f32]| {
            for at in near.touched().flatten() {
                to[at] = from[at] as f32;
            }
        };
        to_single(&finest.diagonal, &mut level.stencil.diagonal);
        for a in 0..D {
            to_single(&finest.coupling[a], &mut level.stencil.coupling[a]);
        }
        level.stencil.rows = finest.rows.clone();
        level.coupling.clone_from(coupling);
        level.derive(|| near.touched());
        self.used = 1;
        while self.used < self.levels.len() && self.levels[self.used - 1].active() > DIRECT {
            let (fine, coarse) = self.levels.split_at_mut(self.used);
            let (fine, coarse) = (&fine[fine.len() - 1], &mut coarse[0]);
            let Level { shape, stencil, held, .. } = fine;
            coarsen(shape, stencil, held, fine.full(), &coarse.shape, &mut coarse.stencil);
            let parent = |at| fine.shape.parent(&coarse.shape, at);
            let children = fine.shape.pair.iter().product();
            fine.coupling.coarsen(parent, children, RESOLVED[D - 1], &mut coarse.coupling);
            let stored = coarse.shape.stored;
            coarse.derive(|| std::iter::once(0..stored));
            self.used += 1;
        }
        self.factorise();
    }

    /// Prepares the direct solution of the coarsest level in use.
    fn factorise(&mut self) {
        let level = &self.levels[self.used - 1];
        let spans = level.stencil.rows.all_spans().flatten();
        self.unknowns = spans.filter(|&at| level.inverse[at] > 0.0).map(|at| at as u32).collect();
        let n = self.unknowns.len();
        let mut matrix = DMatrix::<f64>::zeros(n, n);
        for (row, &at) in self.unknowns.iter().enumerate() {
            let at = at as usize;
            matrix[(row, row)] = f64::from(level.stencil.diagonal[at]) * (1.0 + REGULAR);
            for a in 0..D {
                let below = level.shape.below(a, at) as u32;
                if let Ok(column) = self.unknowns.binary_search(&below) {
                    let coupling = f64::from(level.stencil.coupling[a][at]);
                    matrix[(row, column)] -= coupling;
                    matrix[(column, row)] -= coupling;
                }
            }
        }
        let coupling = &level.coupling;
        let row_of = |at: u32| self.unknowns.binary_search(&at).ok();
        for body in 0..coupling.count() {
            for one in coupling.entries(body) {
                for other in coupling.entries(body) {
                    let (Some(row), Some(column)) =
                        (row_of(coupling.cells[one]), row_of(coupling.cells[other]))
                    else {
                        continue;
                    };
                    let moved = coupling.moved(body, &coupling.wrenches[other]);
                    matrix[(row, column)] += dot6(&coupling.wrenches[one], &moved);
                }
            }
        }
        self.direct = Cholesky::new(matrix);
    }

    /// Approximate solution of the finest level's equation with right side `b`.
    pub fn precondition(&mut self, team: &mut Team, variant: Variant, b: &[f64], out: &mut [f64]) {
        let Level { stencil, b: single, .. } = &mut self.levels[0];
        stencil.rows.fill(team, variant, single, &Single(b));
        self.cycle(team, variant);
        let Level { stencil, q, .. } = &self.levels[0];
        stencil.rows.fill(team, variant, out, &Double(q));
    }

    fn cycle(&mut self, team: &mut Team, variant: Variant) {
        for k in 0..self.used - 1 {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let (fine, coarse) = (&mut fine[k], &mut coarse[0]);
            fine.smooth_from_zero(team, variant, self.weights);
            fine.leave(team, variant);
            let Level { interpolation, rest, .. } = fine;
            interpolation.restrict(team, rest, &coarse.slope, &mut coarse.b);
        }
        self.solve_coarsest();
        for k in (0..self.used - 1).rev() {
            let (fine, coarse) = self.levels.split_at_mut(k + 1);
            let (fine, coarse) = (&mut fine[k], &mut coarse[0]);
            let Level { interpolation, inverse, q, .. } = &mut *fine;
            interpolation.prolong(team, &mut coarse.q, &coarse.slope, inverse, q);
            fine.smooth(team, variant, [self.weights[1], self.weights[0]]);
        }
    }

    fn solve_coarsest(&mut self) {
        let level = &mut self.levels[self.used - 1];
        let Some(direct) = &self.direct else {
            // A matrix that is not positive definite to rounding: the diagonal will do.
            for &at in &self.unknowns {
                level.q[at as usize] = level.inverse[at as usize] * level.b[at as usize];
            }
            return;
        };
        let b = self.unknowns.iter().map(|&at| f64::from(level.b[at as usize]));
        let mut b = nalgebra::DVector::from_iterator(self.unknowns.len(), b);
        direct.solve_mut(&mut b);
        for (&at, &q) in self.unknowns.iter().zip(b.iter()) {
            level.q[at as usize] = q as f32;
        }
    }
}

impl<const D: usize> Level<D> {
    fn new(shape: LevelShape<D>, is_seam: [bool; D]) -> Self {
        let zeros = || vec![0.0; shape.stored];
        Self {
            interpolation: Interpolation::new(&shape),
            shape,
            is_seam,
            stencil: Stencil::empty(shape.stored, shape.stride, shape.ghosts(|_| true)),
            coupling: BodyCoupling::default(),
            light: LightBodies::default(),
            inverse: zeros(),
            held: zeros(),
            full: [0.0; D],
            slope: std::array::from_fn(|_| zeros()),
            q: zeros(),
            b: zeros(),
            rest: zeros(),
        }
    }

    /// Coupling of an open face across whichever axis has the largest.
    fn full(&self) -> f32 {
        self.full.into_iter().fold(0.0, f32::max)
    }

    /// Number of cells that take part.
    fn active(&self) -> usize {
        self.stencil.rows.all_spans().flatten().filter(|&at| self.inverse[at] > 0.0).count()
    }

    /// Derives what follows from the coefficients, in ranges outside of which nothing changes.
    fn derive<I: Iterator<Item = Range<usize>>>(&mut self, spans: impl Fn() -> I) {
        for at in spans().flatten() {
            let diagonal = self.stencil.diagonal[at];
            self.inverse[at] = if diagonal > 0.0 { 1.0 / diagonal } else { 0.0 };
            self.q[at] = 0.0;
            self.rest[at] = 0.0;
            self.b[at] = 0.0;
        }
        for at in self.stencil.rows.all_spans().flatten() {
            self.held[at] = held_by_air(&self.stencil, at);
        }
        self.stencil.ghosts.fill(&mut self.held);
        self.full = self.stencil.coupling.each_ref().map(|coupling| {
            spans().flatten().map(|at| coupling[at]).fold(f32::MIN_POSITIVE, f32::max)
        });
        for a in 0..D {
            self.derive_slopes(a, spans());
        }
        let full = f64::from(self.full());
        self.light.prepare(&self.stencil, &self.coupling, full);
        self.bear_bodies(full);
    }

    /// Adds to the diagonal what bodies that are not balanced couple a cell to, so that smoothing
    /// stays stable.
    fn bear_bodies(&mut self, full: f64) {
        let coupling = &self.coupling;
        for body in (0..coupling.count()).filter(|&body| coupling.stiffness(body) <= LIGHT * full) {
            let mut sum = [0.0; 6];
            for entry in coupling.entries(body) {
                let wrench = &coupling.wrenches[entry];
                (0..6).for_each(|k| sum[k] += wrench[k].abs());
            }
            for entry in coupling.entries(body) {
                let at = coupling.cells[entry] as usize;
                let moved = coupling.moved(body, &coupling.wrenches[entry]);
                let borne: f64 = (0..6).map(|k| moved[k].abs() * sum[k]).sum();
                if self.inverse[at] > 0.0 {
                    self.inverse[at] /= 1.0 + borne as f32 * self.inverse[at];
                }
            }
        }
    }

    /// Slopes of the interpolation across the faces of one axis.
    fn derive_slopes(&mut self, axis: usize, spans: impl Iterator<Item = Range<usize>>) {
        let stride = self.shape.stride[axis];
        let (length, last) = (self.shape.room[axis] + 2, self.shape.cells[axis] + 1);
        let (coupling, full) = (&self.stencil.coupling[axis], self.full[axis]);
        let is_active = |at: usize| self.inverse[at] > 0.0;
        let slope = &mut self.slope[axis];
        for at in spans.flatten() {
            if at < stride {
                slope[at] = 0.0;
                continue;
            }
            if self.is_seam[axis] && [1, last].contains(&(at / stride % length)) {
                slope[at] = 0.0;
                continue;
            }
            slope[at] = match (is_active(at - stride), is_active(at)) {
                (true, true) => 0.25 * coupling[at] / full,
                (false, true) => 0.25 * (self.held[at] / full).min(4.0),
                (true, false) => 0.25 * (self.held[at - stride] / full).min(4.0),
                (false, false) => 0.0,
            };
        }
    }

    /// What is left of the equation: `rest = b - A q`.
    fn leave(&mut self, team: &mut Team, variant: Variant) {
        let Self { stencil, coupling, q, b, rest, .. } = self;
        stencil.residual(team, variant, q, b, rest);
        coupling.apply(q, rest, |_| -1.0);
        stencil.ghosts.clear(rest);
    }

    /// Balances light bodies, in their order or back.
    fn balance(&mut self, is_back: bool) {
        let Self { stencil, coupling, light, q, b, rest, .. } = self;
        for k in 0..light.count() {
            let number = if is_back { light.count() - 1 - k } else { k };
            stencil.ghosts.fill(q);
            light.balance(number, stencil, coupling, b, q, rest);
        }
    }

    /// Smooths, beginning from 0.
    fn smooth_from_zero(&mut self, team: &mut Team, variant: Variant, weights: [f32; 2]) {
        if !self.light.is_empty() {
            for span in self.stencil.rows.all_spans() {
                self.q[span].fill(0.0);
            }
            return self.smooth(team, variant, weights);
        }
        let Self { stencil, coupling, inverse, q, b, rest, .. } = self;
        let first = FirstStep { weight: weights[0], inverse, b };
        stencil.rows.fill(team, variant, rest, &first);
        stencil.relax(team, variant, weights[1], inverse, rest, b, q);
        coupling.apply(rest, q, |at| -f64::from(weights[1] * inverse[at]));
    }

    /// Smooths. Where there are light bodies, their wrenches stay balanced; in between they keep
    /// their motion.
    fn smooth(&mut self, team: &mut Team, variant: Variant, weights: [f32; 2]) {
        self.balance(false);
        self.light.hold(&self.coupling, &self.q);
        self.relax(team, variant, weights[0]);
        self.relax(team, variant, weights[1]);
        self.balance(true);
    }

    fn relax(&mut self, team: &mut Team, variant: Variant, weight: f32) {
        let Self { stencil, coupling, light, inverse, q, b, rest, .. } = self;
        stencil.relax(team, variant, weight, inverse, q, b, rest);
        for body in 0..coupling.count() {
            let motion = light.motion_while_smoothing(coupling, body, q);
            coupling.add_flux(body, &motion, rest, |at| -f64::from(weight * inverse[at]));
        }
        std::mem::swap(q, rest);
    }
}
