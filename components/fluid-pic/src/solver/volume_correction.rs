//! A correction of positions that keeps the volume: `div d = share (m/m0 - 1)`, `d = - grad phi`.
//!
//! Particles that follow an interpolated flow gather here and thin out there. A source in the
//! pressure's equation would push them apart, but as an impulse: pressures become noise, and energy
//! grows. So particles are moved by a displacement of its own, which changes no velocity (Kugelstadt,
//! Longva, Thuerey & Bender, *IEEE Trans. Vis. Comput. Graphics* 27 (2021) 1841). What gathers does
//! so over few cells: a few steps of conjugate gradients find enough of the displacement.

use crate::grid::near_rows::NearRows;
use crate::grid::row_sums::RowSums;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::from_grid::FaceVelocity;
use crate::pressure::stencil::Stencil;
use tremie_team::{Team, Variant};

/// Steps of the iteration.
const ITERATIONS: usize = 8;
/// Largest excess or lack of mass that counts, relative.
const MOST: f64 = 0.5;
/// Largest displacement in a step, in edges of cells.
const FARTHEST: f64 = 0.1;

/// The displacement, and room to work in.
pub struct VolumeCorrection<const D: usize> {
    /// Displacement on faces [m].
    pub displacement: FaceVelocity<D>,
    potential: Vec<f64>,
    residual: Vec<f64>,
    scaled: Vec<f64>,
    direction: Vec<f64>,
    applied: Vec<f64>,
    sums: RowSums,
}

impl<const D: usize> VolumeCorrection<D> {
    /// For a grid.
    pub fn new(grid: &StaggeredGrid<D>) -> Self {
        let zeros = || vec![0.0; grid.stored];
        Self {
            displacement: std::array::from_fn(|_| zeros()),
            potential: zeros(),
            residual: zeros(),
            scaled: zeros(),
            direction: zeros(),
            applied: zeros(),
            sums: RowSums::default(),
        }
    }

    /// Finds the displacement, in the cells that have a pressure. `excess` is the share of a full
    /// cell's mass that is to leave each cell; `to_surface` is the distance of the surface between
    /// two cells, the wet one first, in edges.
    #[expect(clippy::too_many_arguments, reason = "an equation and what its solution is made of")]
    pub fn find(
        &mut self,
        team: &mut Team,
        variant: Variant,
        (grid, near): (&StaggeredGrid<D>, &NearRows),
        stencil: &Stencil<f64, D>,
        open: &[Vec<f64>; D],
        excess: impl Fn(usize) -> f64,
        to_surface: impl Fn(usize, usize) -> f64,
    ) {
        for array in [&mut self.potential, &mut self.residual] {
            near.clear_left(array, 0.0);
            near.fill(array, 0.0);
        }
        for at in stencil.rows.all_spans().flatten() {
            if stencil.diagonal[at] > 0.0 {
                self.residual[at] = excess(at).clamp(-MOST, MOST);
            }
        }
        self.solve(team, variant, stencil);
        stencil.ghosts.fill(&mut self.potential);
        let (potential, farthest) = (&self.potential, FARTHEST * grid.spacing);
        let has = |at: usize| stencil.diagonal[at] > 0.0;
        for (a, displacement) in self.displacement.iter_mut().enumerate() {
            let stride = grid.stride[a];
            near.clear_left(displacement, 0.0);
            for at in near.spans().flatten().filter(|&at| at >= stride) {
                let below = at - stride;
                let fall = match (has(below), has(at)) {
                    _ if open[a][at] == 0.0 => 0.0,
                    (true, true) => potential[below] - potential[at],
                    (true, false) => potential[below] / to_surface(below, at),
                    (false, true) => -potential[at] / to_surface(at, below),
                    (false, false) => 0.0,
                };
                displacement[at] = (fall * grid.spacing).clamp(-farthest, farthest);
            }
            stencil.ghosts.fill(displacement);
        }
    }

    /// Conjugate gradients, preconditioned by the diagonal, beginning from 0.
    fn solve(&mut self, team: &mut Team, variant: Variant, stencil: &Stencil<f64, D>) {
        let Self { potential, residual, scaled, direction, applied, sums, .. } = self;
        let rows = &stencil.rows;
        let mut before = 0.0;
        for iteration in 0..ITERATIONS {
            stencil.scale(team, variant, residual, scaled);
            let [now] = sums.dots(team, variant, rows, [[&**residual, scaled]]);
            if now <= 0.0 {
                break;
            }
            let beta = if iteration == 0 { 0.0 } else { now / before };
            rows.turn((team, variant), direction, beta, scaled);
            stencil.apply(team, variant, direction, applied);
            let [curvature] = sums.dots(team, variant, rows, [[&**direction, applied]]);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let alpha = now / curvature;
            rows.add_scaled((team, variant), potential, alpha, direction);
            rows.add_scaled((team, variant), residual, -alpha, applied);
            before = now;
        }
    }
}
