//! Preconditioned conjugate gradients for the pressure.

use crate::pressure::body_coupling::BodyCoupling;
use crate::pressure::multigrid::Multigrid;
use crate::pressure::stencil::Stencil;
use tremie_team::{Team, Variant};

/// Outcome of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        Self { residual: zeros(), preconditioned: zeros(), direction: zeros(), applied: zeros() }
    }

    /// Solves `(A + J^T S J) q = b`, beginning from the `q` that is there.
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
    ) -> PressureOutcome {
        let rows = &stencil.rows;
        let Self { residual, preconditioned, direction, applied } = self;
        stencil.residual(team, variant, q, b, residual);
        bodies.apply(q, residual, |_| -1.0);
        let largest =
            |r: &[f64]| rows.all_spans().flatten().map(|at| r[at].abs()).fold(0.0, f64::max);
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            rows.all_spans().map(|span| span.map(|at| a[at] * b[at]).sum::<f64>()).sum()
        };
        let start = rows.all_spans().flatten().map(|at| b[at].abs()).fold(0.0, f64::max);
        let goal = (tolerance.relative * start).max(tolerance.absolute);
        let mut left = largest(residual);
        let mut weight = 0.0;
        for iteration in 0..tolerance.iterations {
            if left <= goal {
                return PressureOutcome { iterations: iteration, residual: left, converged: true };
            }
            multigrid.precondition(team, variant, residual, preconditioned);
            let fresh = dot(residual, preconditioned);
            // Polak and Ribiere's choice bears a preconditioner of single precision.
            let beta = if iteration == 0 { 0.0 } else { -dot(preconditioned, applied) * weight };
            for at in rows.all_spans().flatten() {
                direction[at] = preconditioned[at] + beta * direction[at];
            }
            stencil.apply(team, variant, direction, applied);
            bodies.apply(direction, applied, |_| 1.0);
            let curvature = dot(direction, applied);
            if !(curvature > 0.0) {
                break;
            }
            let alpha = dot(direction, residual) / curvature;
            for at in rows.all_spans().flatten() {
                q[at] += alpha * direction[at];
                residual[at] -= alpha * applied[at];
            }
            weight = alpha / fresh;
            left = largest(residual);
        }
        PressureOutcome {
            iterations: tolerance.iterations,
            residual: left,
            converged: left <= goal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::staggered_grid::StaggeredGrid;

    /// A tank in part full of water, with a wave on it, and solid round obstacles cut by sampling.
    fn tank<const D: usize>(
        n: usize,
        radius: f64,
        ratio: f64,
    ) -> (Stencil<f64, D>, BodyCoupling, Vec<f64>) {
        let grid = StaggeredGrid::<D>::new([n; D], 1.0 / n as f64, [0.0; D], [false; D]);
        let up = D - 1;
        let wet = |x: [f64; D]| {
            x[up]
                < std::env::var("LEVEL").map_or(0.7, |v| v.parse().unwrap())
                    + std::env::var("WAVE").map_or(0.1, |v| v.parse().unwrap()) * (9.0 * x[0]).sin()
        };
        let solid = |x: [f64; D]| {
            // Discs in a lattice of a quarter.
            let r2: f64 = x.iter().map(|x| ((4.0 * x).fract() / 4.0 - 0.125).powi(2)).sum();
            r2 < radius * radius
        };
        let mut stencil = Stencil::empty(grid.stored, grid.stride);
        let mut open: [Vec<f64>; D] = std::array::from_fn(|_| vec![0.0; grid.stored]);
        for at in grid.all() {
            for a in 0..D {
                if at[a] == 0 {
                    continue;
                }
                let face = grid.face_centre(a, at);
                let m: usize = if D == 2 { 16 } else { 6 };
                let mut count = 0;
                let total = m.pow(D as u32 - 1);
                for k in 0..total {
                    let mut x = face;
                    let mut k = k;
                    for c in (0..D).filter(|&c| c != a) {
                        x[c] += grid.spacing * (((k % m) as f64 + 0.5) / m as f64 - 0.5);
                        k /= m;
                    }
                    count += usize::from(!solid(x));
                }
                open[a][grid.place(at)] = count as f64 / total as f64;
            }
        }
        for at in grid.all() {
            let place = grid.place(at);
            if !wet(grid.centre(at)) {
                continue;
            }
            let mut sum = 0.0;
            for a in 0..D {
                sum += open[a][place] + open[a][place + grid.stride[a]];
            }
            if sum > 0.0 {
                stencil.diagonal[place] = sum;
            }
        }
        for a in 0..D {
            for at in grid.all() {
                if at[a] == 0 {
                    continue;
                }
                let place = grid.place(at);
                let one = stencil.diagonal[place] > 0.0;
                let other = stencil.diagonal[place - grid.stride[a]] > 0.0;
                if one && other {
                    stencil.coupling[a][place] = open[a][place];
                }
            }
        }
        let mut bodies = BodyCoupling::default();
        bodies.clear();
        if ratio > 0.0 {
            let discs = 4_usize.pow(D as u32);
            let mass = ratio
                * if D == 2 {
                    std::f64::consts::PI * radius * radius
                } else {
                    4.0 / 3.0 * std::f64::consts::PI * radius.powi(3)
                };
            let mut lists = vec![Vec::new(); discs];
            for at in grid.all() {
                let x = grid.centre(at);
                let mut number = 0;
                for a in (0..D).rev() {
                    number = number * 4 + ((4.0 * x[a]) as usize).min(3);
                }
                let place = grid.place(at);
                let mut w = [0.0; 6];
                for a in 0..D {
                    if at[a] == 0 || at[a] + 1 == n as isize {
                        continue;
                    }
                    w[a] = -(open[a][place + grid.stride[a]] - open[a][place]);
                }
                if w != [0.0; 6] && stencil.diagonal[place] > 0.0 {
                    lists[number].push((place, w));
                }
            }
            for list in lists {
                for (place, w) in list {
                    bodies.cells.push(place as u32);
                    bodies.wrenches.push(w);
                }
                let mut m = [[0.0; 6]; 6];
                for a in 0..D {
                    m[a][a] = grid.cell_volume() / mass;
                }
                bodies.close_body(m);
            }
        }
        let row = grid.stride[1];
        let d = &stencil.diagonal;
        let rows = crate::grid::cell_rows::CellRows::new(grid.stored, row, |at| d[at] > 0.0);
        stencil.rows = rows;
        let mut b = vec![0.0; grid.stored];
        let mut seed = 12345_u64;
        for at in grid.all() {
            let place = grid.place(at);
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            if stencil.diagonal[place] > 0.0 {
                b[place] = (seed >> 40) as f64 / (1u64 << 24) as f64 - 0.5
                    + (7.0 * grid.centre(at)[0]).sin();
            }
        }
        (stencil, bodies, b)
    }

    fn iterations<const D: usize>(n: usize, radius: f64, ratio: f64) -> usize {
        let (stencil, bodies, b) = tank::<D>(n, radius, ratio);
        let mut team = Team::new("test", 1).unwrap();
        let mut multigrid = Multigrid::new([n; D]);
        let begun = std::time::Instant::now();
        multigrid.prepare(&stencil, &bodies);
        let prepared = begun.elapsed();
        let mut cg = ConjugateGradients::new(b.len());
        let mut q = vec![0.0; b.len()];
        let tolerance = Tolerance { relative: 1e-8, absolute: 0.0, iterations: 300 };
        let begun = std::time::Instant::now();
        let outcome = cg.solve(
            &mut team,
            Variant::widest(),
            &stencil,
            &bodies,
            &mut multigrid,
            &b,
            &mut q,
            tolerance,
        );
        let active = stencil.diagonal.iter().filter(|&&d| d > 0.0).count();
        let per = begun.elapsed().as_secs_f64() / active as f64 / outcome.iterations as f64;
        println!(
            "{D}-D {n} radius {radius} ratio {ratio}: {outcome:?} prepare {:.0} ns/cell, {:.1} ns a cell and iteration",
            prepared.as_secs_f64() / active as f64 * 1e9,
            per * 1e9
        );
        outcome.iterations
    }

    #[test]
    fn explore() {
        for n in
            [64, 256, 1024].into_iter().take(std::env::var("N").map_or(9, |v| v.parse().unwrap()))
        {
            iterations::<2>(n, 0.0, 0.0);
            iterations::<2>(n, 0.08, 0.0);
            iterations::<2>(n, 0.08, 2.0);
            iterations::<2>(n, 0.08, 0.1);
            iterations::<2>(n, 0.08, 0.01);
        }
        for n in [32, 128].into_iter().take(std::env::var("N").map_or(9, |v| v.parse().unwrap())) {
            iterations::<3>(n, 0.0, 0.0);
            iterations::<3>(n, 0.1, 0.0);
            iterations::<3>(n, 0.1, 1.0);
            iterations::<3>(n, 0.1, 0.01);
        }
    }
}
