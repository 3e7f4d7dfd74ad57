//! The equations of the viscous step, of all components at once: bodies that turn couple them.

use crate::grid::row_sums::RowSums;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::pressure::body_coupling::dot6;
use crate::pressure::stencil::Stencil;
use crate::solids::open_fractions::NONE;
use crate::solver::dragged_body::DraggedBody;
use crate::solver::wall_links::{ViscousStep, WallLink, wall_link};
use tremie_team::{Team, Variant};

/// What is left of the largest imbalance.
const TOLERANCE: f64 = 1e-9;
/// Most steps of the iteration.
const ITERATIONS: usize = 500;

/// Equations of one component, and room to work in.
pub struct ShearEquations<const D: usize> {
    stencil: Stencil<f64, D>,
    /// Right side; free bodies are added when their links are known.
    pub right: Vec<f64>,
    residual: Vec<f64>,
    scaled: Vec<f64>,
    direction: Vec<f64>,
    applied: Vec<f64>,
    sums: RowSums,
}

impl<const D: usize> ShearEquations<D> {
    /// For a grid.
    pub fn new(grid: &StaggeredGrid<D>) -> Self {
        let zeros = || vec![0.0; grid.stored];
        Self {
            stencil: Stencil::of_grid(grid),
            right: zeros(),
            residual: zeros(),
            scaled: zeros(),
            direction: zeros(),
            applied: zeros(),
            sums: RowSums::default(),
        }
    }

    /// Fills the coefficients of the component along an axis, on the faces that `is_carried`, and
    /// adds its links.
    pub fn assemble(
        &mut self,
        step: &ViscousStep<D>,
        axis: usize,
        is_carried: &[bool],
        velocity: &[f64],
        links: &mut Vec<WallLink>,
    ) {
        let ViscousStep { grid, fractions, number, .. } = *step;
        let Self { stencil, right, .. } = self;
        stencil.diagonal.fill(0.0);
        stencil.coupling.iter_mut().for_each(|coupling| coupling.fill(0.0));
        right.fill(0.0);
        let is_fluid = |at: usize| {
            is_carried[at]
                && fractions.is_cell(at)
                && fractions.open[axis][at] > 0.0
                && fractions.holder[axis][at] == NONE
        };
        for cell in grid.all() {
            let at = grid.place(cell);
            if !is_fluid(at) {
                continue;
            }
            let (mut diagonal, mut source) = (1.0, velocity[at]);
            for b in 0..D {
                for (side, other) in
                    [at - grid.stride[b], at + grid.stride[b]].into_iter().enumerate()
                {
                    if is_fluid(other) {
                        diagonal += number;
                        stencil.coupling[b][if side == 0 { at } else { other }] = number;
                    } else if let Some(link) = wall_link(step, axis, cell, at, (b, side), other) {
                        diagonal += link.weight;
                        if link.free == NONE {
                            source += link.weight * link.velocity;
                        }
                        links.push(link);
                    }
                }
            }
            stencil.diagonal[at] = diagonal;
            right[at] = source;
        }
        stencil.find_rows(grid.row_length());
    }

    /// Scalar product of the direction and the equations' left side of it.
    fn curvature(&mut self, team: &mut Team, variant: Variant) -> f64 {
        let Self { stencil, direction, applied, sums, .. } = self;
        let [sum] = sums.dots(team, variant, &stencil.rows, [[direction, applied]]);
        sum
    }

    /// The largest imbalance at the start, and now.
    fn largest(&mut self, team: &mut Team, variant: Variant) -> [f64; 2] {
        let Self { stencil, right, residual, sums, .. } = self;
        [right, residual].map(|of| sums.largest(team, variant, &stencil.rows, of))
    }

    /// Scales the residual by the diagonal: scalar product of both.
    fn scale_residual(&mut self, team: &mut Team, variant: Variant) -> f64 {
        let Self { stencil, residual, scaled, sums, .. } = self;
        stencil.scale(team, variant, residual, scaled);
        let [sum] = sums.dots(team, variant, &stencil.rows, [[residual, scaled]]);
        sum
    }

    /// The next direction, and the left side of it.
    fn turn_direction(&mut self, team: &mut Team, variant: Variant, beta: f64) {
        let Self { stencil, scaled, direction, applied, .. } = self;
        stencil.rows.turn((team, variant), direction, beta, scaled);
        stencil.apply(team, variant, direction, applied);
    }

    fn advance(&mut self, team: &mut Team, variant: Variant, alpha: f64, u: &mut [f64]) {
        let Self { stencil, residual, direction, applied, .. } = self;
        stencil.rows.add_scaled((team, variant), u, alpha, direction);
        stencil.rows.add_scaled((team, variant), residual, -alpha, applied);
    }
}

/// Solves the equations of all components, whose solutions begin as they are, by conjugate
/// gradients, preconditioned by the diagonal.
pub fn solve<const D: usize>(
    team: &mut Team,
    variant: Variant,
    equations: &mut [ShearEquations<D>],
    (links, dragged): (&[WallLink], &mut [DraggedBody]),
    u: &mut [Vec<f64>; D],
) {
    for (own, u) in equations.iter_mut().zip(&mut *u) {
        own.stencil.residual(team, variant, u, &own.right, &mut own.residual);
    }
    gather(links, dragged, u);
    give_back(links, dragged, equations, |own| &mut own.residual, 1.0);
    let mut before = 0.0;
    for iteration in 0..ITERATIONS {
        let largest = equations.iter_mut().map(|own| own.largest(team, variant));
        let [start, left] =
            largest.fold([0.0_f64; 2], |most, own| [most[0].max(own[0]), most[1].max(own[1])]);
        // The right side stays, so that its largest is that of the start.
        if left <= TOLERANCE * start {
            break;
        }
        let now: f64 = equations.iter_mut().map(|own| own.scale_residual(team, variant)).sum();
        let beta = if iteration == 0 { 0.0 } else { now / before };
        for own in &mut *equations {
            own.turn_direction(team, variant, beta);
        }
        let directions: [&[f64]; D] = std::array::from_fn(|a| &equations[a].direction[..]);
        gather(links, dragged, &directions);
        give_back(links, dragged, equations, |own| &mut own.applied, -1.0);
        let curvature: f64 = equations.iter_mut().map(|own| own.curvature(team, variant)).sum();
        let alpha = now / curvature;
        for (own, u) in equations.iter_mut().zip(&mut *u) {
            own.advance(team, variant, alpha, u);
        }
        before = now;
    }
    for (own, u) in equations.iter().zip(u) {
        own.stencil.ghosts.fill(u);
    }
}

/// Sums what links pull their bodies with, at velocities of faces.
pub fn gather<U: AsRef<[f64]>>(links: &[WallLink], dragged: &mut [DraggedBody], u: &[U]) {
    if dragged.is_empty() {
        return;
    }
    dragged.iter_mut().for_each(|body| body.pull = [0.0; 6]);
    for link in links.iter().filter(|link| link.free != NONE) {
        let own = u[usize::from(link.axis)].as_ref()[link.face as usize];
        dragged[link.free as usize].add_pull(link.weight * own, &link.arm);
    }
}

/// Gives to the faces what bodies that follow them give back, times a factor.
fn give_back<const D: usize>(
    links: &[WallLink],
    dragged: &mut [DraggedBody],
    equations: &mut [ShearEquations<D>],
    out: impl Fn(&mut ShearEquations<D>) -> &mut Vec<f64>,
    factor: f64,
) {
    dragged.iter_mut().for_each(DraggedBody::follow);
    for link in links.iter().filter(|link| link.free != NONE) {
        let following = dot6(&link.arm, &dragged[link.free as usize].pull);
        let out = out(&mut equations[usize::from(link.axis)]);
        out[link.face as usize] += factor * link.weight * following;
    }
}
