//! A tank with a wave on it and round bodies in a lattice: iterations, solutions, threads.

use super::*;
use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::solids::open_fractions::OpenFractions;
use crate::solids::rigid_body::RigidBody;
use std::f64::consts::PI;

/// Bodies of a tank along each axis.
const BODIES: usize = 4;

/// The equations of a tank of `n` cells along each axis.
struct Tank<const D: usize> {
    grid: StaggeredGrid<D>,
    stencil: Stencil<f64, D>,
    coupling: BodyCoupling,
    right: Vec<f64>,
}

/// Bodies of a density relative to the fluid's.
fn bodies<const D: usize>(radius: f64, ratio: f64) -> Vec<RigidBody<D>> {
    let volume = match D {
        2 => PI * radius * radius,
        _ => 4.0 / 3.0 * PI * radius.powi(3),
    };
    let centre = |mut number: usize| {
        std::array::from_fn(|_| {
            let along = number % BODIES;
            number /= BODIES;
            (along as f64 + 0.5) / BODIES as f64
        })
    };
    let body = |number| RigidBody::ball(centre(number), radius).with_mass(ratio * volume);
    (0..BODIES.pow(D as u32)).map(body).collect()
}

impl<const D: usize> Tank<D> {
    fn new(n: usize, radius: f64, ratio: f64) -> Self {
        let grid = StaggeredGrid::<D>::new([n; D], 1.0 / n as f64, [0.0; D], [false; D]);
        let mut fractions = OpenFractions::new(&grid, |_, _| false, Vec::new());
        let bodies = bodies(radius, ratio);
        fractions.place_bodies(&grid, &bodies, grid.cell_volume());
        let mut coupling = fractions.free.coupling.clone();
        let is_wet = |at: usize| {
            let x = grid.centre(grid.cell_at(at));
            x[D - 1] < 0.7 + 0.1 * (9.0 * x[0]).sin() && fractions.volume[at] > 0.0
        };
        let mut stencil = Stencil::of_grid(&grid);
        let mut right = vec![0.0; grid.stored];
        for cell in grid.all() {
            let at = grid.place(cell);
            if !is_wet(at) {
                continue;
            }
            for a in 0..D {
                for (face, beyond) in
                    [(at, at - grid.stride[a]), (at + grid.stride[a], at + grid.stride[a])]
                {
                    let open = fractions.open[a][face];
                    stencil.diagonal[at] += open;
                    if open > 0.0 && is_wet(beyond) {
                        stencil.coupling[a][face] = open;
                    }
                }
            }
            // Something smooth and something rough.
            let rough = (at as u64).wrapping_mul(6_364_136_223_846_793_005) >> 40;
            right[at] =
                rough as f64 / f64::from(1 << 24) - 0.5 + (7.0 * grid.centre(cell)[0]).sin();
        }
        for (cell, wrench) in coupling.cells.iter().zip(&mut coupling.wrenches) {
            if stencil.diagonal[*cell as usize] == 0.0 {
                *wrench = [0.0; 6];
            }
        }
        stencil.find_rows(grid.row_length());
        right
            .iter_mut()
            .zip(&stencil.diagonal)
            .for_each(|(b, &d)| *b = if d > 0.0 { *b } else { 0.0 });
        Self { grid, stencil, coupling, right }
    }

    fn solve(&self, threads: usize) -> (Vec<f64>, PressureOutcome) {
        let mut team = Team::new("test", threads).unwrap();
        let mut multigrid = Multigrid::new(self.grid.cells, self.grid.periodic);
        multigrid.prepare(&self.stencil, &NearRows::whole(&self.grid), &self.coupling);
        let mut iteration = ConjugateGradients::new(self.grid.stored);
        let mut q = vec![0.0; self.grid.stored];
        let outcome = iteration.solve(
            &mut team,
            Variant::widest(),
            &self.stencil,
            &self.coupling,
            &mut multigrid,
            &self.right,
            &mut q,
            Tolerance { relative: 1e-8, absolute: 0.0, iterations: 60 },
            true,
        );
        (q, outcome)
    }
}

/// Iterations to 1e-8 hardly grow with the grid, nor as bodies become light. On grids whose coarse
/// levels do not fit the lattice of bodies they are up to twice as many (96 cells here).
#[test]
fn iterations_are_few_on_every_grid_and_with_bodies_of_every_mass() {
    let iterations = |outcome: PressureOutcome| {
        assert!(outcome.converged, "{outcome:?}");
        outcome.iterations
    };
    for ratio in [2.0, 1.0, 0.1, 0.01, 0.0001] {
        for n in [64, 96, 256] {
            let count = iterations(Tank::<2>::new(n, 0.08, ratio).solve(1).1);
            assert!(count <= 15, "{n}^2 cells, density {ratio}: {count}");
        }
        // Of hardly any mass, on the coarser of these grids: 23.
        let most = if ratio < 0.01 { 25 } else { 15 };
        for n in [32, 64] {
            let count = iterations(Tank::<3>::new(n, 0.1, ratio).solve(2).1);
            assert!(count <= most, "{n}^3 cells, density {ratio}: {count}");
        }
    }
}

/// The solution solves the equations, bodies included.
#[test]
fn what_is_left_is_what_was_told() {
    let tank = Tank::<2>::new(50, 0.09, 0.3);
    let (q, outcome) = tank.solve(1);
    let mut left = tank.right.clone();
    for at in tank.stencil.rows.all_spans().flatten() {
        left[at] -= tank.stencil.applied_at(&q, at);
    }
    tank.coupling.apply(&q, &mut left, |_| -1.0);
    let most = left.iter().map(|x| x.abs()).fold(0.0, f64::max);
    assert!(most < 1.5 * outcome.residual + 1e-12, "{most} {outcome:?}");
    assert!(outcome.residual < 2e-8);
}

#[test]
fn threads_change_no_bit() {
    let tank = Tank::<3>::new(30, 0.1, 0.5);
    let (alone, told) = tank.solve(1);
    assert!(told.converged);

    for threads in [2, 3] {
        assert!(tank.solve(threads).0 == alone);
    }
}

/// Another way to the same pressures: Cholesky's factors of the whole matrix, dense, with the blocks
/// of the bodies, which are half as heavy as the fluid.
#[test]
fn a_direct_solution_is_the_same() {
    let tank = Tank::<2>::new(28, 0.09, 0.5);
    let cells: Vec<usize> = tank.stencil.rows.all_spans().flatten().collect();
    let cells: Vec<usize> =
        cells.into_iter().filter(|&at| tank.stencil.diagonal[at] > 0.0).collect();
    let n = cells.len();
    let mut matrix = nalgebra::DMatrix::<f64>::zeros(n, n);
    let mut unit = vec![0.0; tank.grid.stored];
    let mut column = vec![0.0; tank.grid.stored];
    for (j, &cell) in cells.iter().enumerate() {
        unit[cell] = 1.0;
        column.fill(0.0);
        for &at in &cells {
            column[at] = tank.stencil.applied_at(&unit, at);
        }
        tank.coupling.apply(&unit, &mut column, |_| 1.0);
        for (i, &at) in cells.iter().enumerate() {
            matrix[(i, j)] = column[at];
        }
        unit[cell] = 0.0;
    }
    assert!((&matrix - matrix.transpose()).amax() < 1e-14);
    let right = nalgebra::DVector::from_iterator(n, cells.iter().map(|&at| tank.right[at]));
    let direct = nalgebra::Cholesky::new(matrix).unwrap().solve(&right);
    let (q, outcome) = tank.solve(1);
    assert!(outcome.converged && n > 400, "{n} {outcome:?}");
    let farthest =
        cells.iter().enumerate().map(|(i, &at)| (q[at] - direct[i]).abs()).fold(0.0, f64::max);
    assert!(farthest < 1e-6 * direct.amax(), "{farthest} {}", direct.amax());
}
