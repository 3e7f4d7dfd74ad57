//! Preconditioned conjugate gradients for the pressure.

use crate::grid::row_sums::RowSums;
use crate::pressure::body_coupling::BodyCoupling;
use crate::pressure::multigrid::Multigrid;
use crate::pressure::stencil::Stencil;
use serde::{Deserialize, Serialize};
use tremie_team::{Team, Variant};

/// Outcome of a solution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureOutcome {
    /// Steps of the iteration.
    pub iterations: usize,
    /// Largest imbalance of a cell's volume that is left [m/s, as the sum of its faces' open
    /// fractions times velocities].
    pub residual: f64,
    /// True if the tolerance was reached.
    pub converged: bool,
}

/// Arrays of the iteration.
pub struct ConjugateGradients {
    residual: Vec<f64>,
    preconditioned: Vec<f64>,
    direction: Vec<f64>,
    applied: Vec<f64>,
    sums: RowSums,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest imbalance over the largest one at the start.
    pub relative: f64,
    /// Largest imbalance [m/s].
    pub absolute: f64,
    /// Greatest number of iterations.
    pub iterations: usize,
}

impl ConjugateGradients {
    /// For arrays of so many stored cells.
    pub fn new(stored: usize) -> Self {
        let zeros = || vec![0.0; stored];
        Self {
            residual: zeros(),
            preconditioned: zeros(),
            direction: zeros(),
            applied: zeros(),
            sums: RowSums::default(),
        }
    }

    /// Solves `(A + J^T S J) q = b`, beginning from the `q` that is there. Unless the level of `q`
    /// `is_held`, by a free surface, any constant is free: its mean is kept at zero.
    #[expect(clippy::too_many_arguments, reason = "an equation, its solution and its solvers")]
    pub fn solve<const D: usize>(
        &mut self,
        team: &mut Team,
        variant: Variant,
        stencil: &Stencil<f64, D>,
        bodies: &BodyCoupling,
        multigrid: &mut Multigrid<D>,
        b: &[f64],
        q: &mut [f64],
        tolerance: Tolerance,
        is_held: bool,
    ) -> PressureOutcome {
        let rows = &stencil.rows;
        let Self { residual, preconditioned, direction, applied, sums } = self;
        let level = |values: &mut [f64]| {
            let cells = || rows.all_spans().flatten().filter(|&at| stencil.diagonal[at] > 0.0);
            let (sum, count) = cells().fold((0.0, 0), |(s, n), at| (s + values[at], n + 1));
            let mean = sum / f64::from(count.max(1));
            cells().for_each(|at| values[at] -= mean);
        };
        if !is_held {
            level(q);
        }
        stencil.residual(team, variant, q, b, residual);
        bodies.apply(q, residual, |_| -1.0);
        let start = sums.largest(team, variant, rows, b);
        let goal = (tolerance.relative * start).max(tolerance.absolute);
        let mut left = sums.largest(team, variant, rows, residual);
        let (mut weight, mut iterations) = (0.0, 0);
        while left > goal && iterations < tolerance.iterations {
            if !is_held {
                level(residual);
            }
            multigrid.precondition(team, variant, residual, preconditioned);
            if !is_held {
                level(preconditioned);
            }
            let pairs = [[&**residual, preconditioned], [&**applied, preconditioned]];
            let [fresh, old] = sums.dots(team, variant, rows, pairs);
            // Polak and Ribiere's choice bears a preconditioner of single precision.
            let beta = if iterations == 0 { 0.0 } else { -old * weight };
            rows.turn((team, variant), direction, beta, preconditioned);
            stencil.apply(team, variant, direction, applied);
            bodies.apply(direction, applied, |_| 1.0);
            let pairs = [[&**applied, direction], [&**residual, direction]];
            let [curvature, along] = sums.dots(team, variant, rows, pairs);
            // Not a number stops it too.
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let alpha = along / curvature;
            rows.add_scaled((team, variant), q, alpha, direction);
            rows.add_scaled((team, variant), residual, -alpha, applied);
            weight = alpha / fresh;
            left = sums.largest(team, variant, rows, residual);
            iterations += 1;
        }
        PressureOutcome { iterations, residual: left, converged: left <= goal }
    }
}

#[cfg(test)]
mod tests;
