//! Viscosity, implicit in time: `(1 - dt nu lap) u = u^n`, one component after the other.
//!
//! A face whose neighbour lies in a body meets the body's surface on the way, at the share `theta`
//! of an edge that the distances of both from the surface give (Gibou et al. 2002); a wall of the
//! box is half an edge away from faces along it. What such a link takes from the fluid, the body
//! gets. Air does not shear the fluid.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::pressure::body_coupling::Wrench;
use crate::pressure::stencil::Stencil;
use crate::solids::open_fractions::{NONE, OpenFractions};
use crate::solids::rigid_body::{RigidBody, cross, padded};
use crate::solver::pic_settings::BoxWall;
use tremie_team::{Team, Variant};

/// Least distance of a wall from a face, in edges of cells.
const NEAREST: f64 = 0.05;
/// What is left of the largest imbalance.
const TOLERANCE: f64 = 1e-9;
/// Most steps of the iteration.
const ITERATIONS: usize = 500;

/// A link from a face of the fluid to a surface.
#[derive(Clone, Copy, Debug)]
struct WallLink {
    face: u32,
    /// The solid, or [`NONE`] for a wall of the box.
    solid: u32,
    /// Axis and side of the box's wall.
    wall: (u8, u8),
    /// One over the distance, in edges of cells.
    weight: f64,
    /// Velocity of the surface [m/s].
    velocity: f64,
}

/// Forces of shear.
#[derive(Clone, Debug)]
pub struct ShearLoads<const D: usize> {
    /// On each solid, those at rest first; forces and torques about their centres.
    pub solids: Vec<Wrench>,
    /// On the walls of the box, lower and upper along each axis.
    pub walls: [[[f64; D]; 2]; D],
}

/// The viscous step, and room to work in.
pub struct Viscosity<const D: usize> {
    stencil: Stencil<f64, D>,
    inverse: Vec<f64>,
    right: Vec<f64>,
    residual: Vec<f64>,
    scaled: Vec<f64>,
    direction: Vec<f64>,
    applied: Vec<f64>,
    links: Vec<WallLink>,
    /// Forces of the last step.
    pub loads: ShearLoads<D>,
}

/// What a viscous step is taken with.
#[derive(Clone, Copy)]
pub struct ViscousStep<'a, const D: usize> {
    /// The grid.
    pub grid: &'a StaggeredGrid<D>,
    /// What solids leave open.
    pub fractions: &'a OpenFractions<D>,
    /// Bodies that move.
    pub bodies: &'a [RigidBody<D>],
    /// Faces of the box.
    pub walls: &'a [[BoxWall<D>; 2]; D],
    /// True if bodies hold the fluid back.
    pub bodies_stick: bool,
    /// Density [kg/m³].
    pub density: f64,
    /// `dt nu / h^2`.
    pub number: f64,
    /// Time step [s].
    pub dt: f64,
}

impl<const D: usize> Viscosity<D> {
    /// For a grid.
    pub fn new(grid: &StaggeredGrid<D>) -> Self {
        let zeros = || vec![0.0; grid.stored];
        Self {
            stencil: Stencil::empty(grid.stored, grid.stride),
            inverse: zeros(),
            right: zeros(),
            residual: zeros(),
            scaled: zeros(),
            direction: zeros(),
            applied: zeros(),
            links: Vec::new(),
            loads: ShearLoads { solids: Vec::new(), walls: [[[0.0; D]; 2]; D] },
        }
    }

    /// Forgets the forces of the last step, with so many solids to come.
    pub fn clear_loads(&mut self, solids: usize) {
        self.loads.solids.clear();
        self.loads.solids.resize(solids, [0.0; 6]);
        self.loads.walls = [[[0.0; D]; 2]; D];
    }

    /// Shears one component of the velocity, on the faces that `is_carried`.
    pub fn shear(
        &mut self,
        team: &mut Team,
        variant: Variant,
        step: &ViscousStep<D>,
        axis: usize,
        is_carried: &[bool],
        velocity: &mut [f64],
    ) {
        self.assemble(step, axis, is_carried, velocity);
        self.solve(team, variant, velocity);
        self.take_loads(step, axis, velocity);
    }

    fn assemble(
        &mut self,
        step: &ViscousStep<D>,
        axis: usize,
        is_carried: &[bool],
        velocity: &[f64],
    ) {
        let ViscousStep { grid, fractions, number, .. } = *step;
        let Self { stencil, inverse, right, links, .. } = self;
        stencil.diagonal.fill(0.0);
        stencil.coupling.iter_mut().for_each(|coupling| coupling.fill(0.0));
        right.fill(0.0);
        inverse.fill(0.0);
        links.clear();
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
                        diagonal += number * link.weight;
                        source += number * link.weight * link.velocity;
                        links.push(link);
                    }
                }
            }
            stencil.diagonal[at] = diagonal;
            inverse[at] = 1.0 / diagonal;
            right[at] = source;
        }
        stencil.find_rows(grid.row_length());
    }

    /// Conjugate gradients, preconditioned by the diagonal.
    fn solve(&mut self, team: &mut Team, variant: Variant, u: &mut [f64]) {
        let Self { stencil, inverse, right, residual, scaled, direction, applied, .. } = self;
        stencil.residual(team, variant, u, right, residual);
        let spans = || stencil.rows.all_spans().flatten();
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            stencil.rows.all_spans().map(|span| span.map(|at| a[at] * b[at]).sum::<f64>()).sum()
        };
        let largest = |r: &[f64]| spans().map(|at| r[at].abs()).fold(0.0, f64::max);
        let goal = TOLERANCE * largest(right);
        let mut before = 0.0;
        for iteration in 0..ITERATIONS {
            if largest(residual) <= goal {
                break;
            }
            for at in spans() {
                scaled[at] = inverse[at] * residual[at];
            }
            let now = dot(residual, scaled);
            let beta = if iteration == 0 { 0.0 } else { now / before };
            for at in spans() {
                direction[at] = scaled[at] + beta * direction[at];
            }
            stencil.apply(team, variant, direction, applied);
            let alpha = now / dot(direction, applied);
            for at in spans() {
                u[at] += alpha * direction[at];
                residual[at] -= alpha * applied[at];
            }
            before = now;
        }
    }

    /// Gives what the links took from the fluid to bodies and walls: `mu h^(D-2) weight (u - u_wall)`.
    fn take_loads(&mut self, step: &ViscousStep<D>, axis: usize, velocity: &[f64]) {
        let ViscousStep { grid, fractions, bodies, density, number, dt, .. } = *step;
        let unit = density * grid.cell_volume() * number / dt;
        for link in &self.links {
            let force = unit * link.weight * (velocity[link.face as usize] - link.velocity);
            if link.solid == NONE {
                let (a, side) = link.wall;
                self.loads.walls[usize::from(a)][usize::from(side)][axis] += force;
                continue;
            }
            let centre = grid.face_centre(axis, grid.cell_at(link.face as usize));
            let body = fractions.solid(bodies, link.solid as usize);
            let arm = padded::<D>(std::array::from_fn(|a| centre[a] - body.centre[a]));
            let along = std::array::from_fn(|a| if a == axis { force } else { 0.0 });
            let turn = cross(arm, along);
            let load = &mut self.loads.solids[link.solid as usize];
            load[axis] += force;
            (0..3).for_each(|k| load[3 + k] += turn[k]);
        }
    }
}

/// The link from a face of the fluid to what is beyond it on one side along an axis, if that is a
/// surface that holds the fluid back.
fn wall_link<const D: usize>(
    step: &ViscousStep<D>,
    axis: usize,
    cell: [isize; D],
    at: usize,
    (b, side): (usize, usize),
    other: usize,
) -> Option<WallLink> {
    let ViscousStep { grid, fractions, bodies, walls, bodies_stick, .. } = *step;
    let face = at as u32;
    let holder = fractions.holder[axis][other];
    if holder != NONE {
        if !bodies_stick {
            return None;
        }
        let body = fractions.solid(bodies, holder as usize);
        let from = grid.face_centre(axis, cell);
        let mut to = from;
        to[b] += [-1.0, 1.0][side] * grid.spacing;
        let reach = 2.0 * grid.spacing;
        let height = |point| body.height(point, reach).map_or(reach, |(height, _)| height.abs());
        let (outside, inside) = (height(from), height(to));
        let theta = (outside / (outside + inside).max(f64::MIN_POSITIVE)).clamp(NEAREST, 1.0);
        let mut met = from;
        met[b] += [-1.0, 1.0][side] * theta * grid.spacing;
        let velocity = body.velocity_at(met)[axis];
        return Some(WallLink { face, solid: holder, wall: (0, 0), weight: 1.0 / theta, velocity });
    }
    let wall = (b as u8, side as u8);
    if b == axis {
        // Where the neighbour is a face of a wall, nothing passes.
        let upper = if side == 0 { other } else { at + grid.stride[b] };
        let is_wall = fractions.is_wall(axis, upper, upper - grid.stride[axis]);
        return is_wall.then_some(WallLink { face, solid: NONE, wall, weight: 1.0, velocity: 0.0 });
    }
    let is_beyond = [cell[b] == 0, cell[b] + 1 == grid.cells[b] as isize][side];
    match walls[b][side] {
        BoxWall::Stick(velocity) if is_beyond => {
            Some(WallLink { face, solid: NONE, wall, weight: 2.0, velocity: velocity[axis] })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
