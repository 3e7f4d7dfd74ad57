//! Links from faces of the fluid to the surfaces that hold it back.
//!
//! A face whose neighbour lies in a body meets the body's surface on the way, at the share `theta`
//! of an edge that the distances of both from the surface give (Gibou et al. 2002); a wall of the
//! box is half an edge away from faces along it.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::pressure::body_coupling::Wrench;
use crate::solids::open_fractions::{NONE, OpenFractions};
use crate::solids::rigid_body::{RigidBody, cross, padded};
use crate::solver::pic_settings::BoxWall;

/// Least distance of a wall from a face, in edges of cells.
const NEAREST: f64 = 0.05;

/// A link from a face of the fluid to a surface.
#[derive(Clone, Copy, Debug)]
pub struct WallLink {
    /// The face.
    pub face: u32,
    /// The axis across it.
    pub axis: u8,
    /// The solid, or [`NONE`] for a wall of the box.
    pub solid: u32,
    /// Axis and side of the box's wall.
    pub wall: (u8, u8),
    /// `dt nu / h^2` over the distance, in edges of cells.
    pub weight: f64,
    /// Velocity of the surface [m/s].
    pub velocity: f64,
    /// What velocities of the solid make it.
    pub arm: Wrench,
    /// Number among the bodies that are free, or [`NONE`].
    pub free: u32,
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
    /// Changes of the free bodies' motions by all but shear that are expected in this step.
    pub gains: &'a [Wrench],
}

/// The link from a face of the fluid to what is beyond it on one side along an axis, if that is a
/// surface that holds the fluid back.
pub fn wall_link<const D: usize>(
    step: &ViscousStep<D>,
    axis: usize,
    cell: [isize; D],
    at: usize,
    (b, side): (usize, usize),
    other: usize,
) -> Option<WallLink> {
    let ViscousStep { grid, fractions, bodies, walls, bodies_stick, number, .. } = *step;
    let face = (at as u32, axis as u8);
    let holder = fractions.holder[axis][other];
    if holder != NONE {
        if !bodies_stick {
            return None;
        }
        let from = grid.face_centre(axis, cell);
        let (body, from) = fractions.seen_by(grid, bodies, holder as usize, from);
        let mut to = from;
        to[b] += [-1.0, 1.0][side] * grid.spacing;
        let reach = 2.0 * grid.spacing;
        let height = |point| body.height(point, reach).map_or(reach, |(height, _)| height.abs());
        let (outside, inside) = (height(from), height(to));
        let theta = (outside / (outside + inside).max(f64::MIN_POSITIVE)).clamp(NEAREST, 1.0);
        let mut met = from;
        met[b] += [-1.0, 1.0][side] * theta * grid.spacing;
        let velocity = body.velocity_at(met)[axis];
        let lever = padded::<D>(std::array::from_fn(|a| met[a] - body.centre[a]));
        let along: [f64; 3] = std::array::from_fn(|a| if a == axis { 1.0 } else { 0.0 });
        let turn = cross(lever, along);
        let arm = [along[0], along[1], along[2], turn[0], turn[1], turn[2]];
        let free = free_number(step, holder as usize);
        let weight = number / theta;
        return Some(WallLink {
            weight,
            arm,
            free,
            solid: holder,
            ..at_box(face, (0, 0), velocity)
        });
    }
    let wall = (b as u8, side as u8);
    if b == axis {
        // Where the neighbour is shut, nothing passes.
        let upper = if side == 0 { other } else { at + grid.stride[b] };
        let is_shut = fractions.is_shut(axis, upper, upper - grid.stride[axis]);
        return is_shut.then_some(WallLink { weight: number, ..at_box(face, wall, 0.0) });
    }
    let is_beyond = [cell[b] == 0, cell[b] + 1 == grid.cells[b] as isize][side];
    match walls[b][side] {
        BoxWall::Stick(velocity) if is_beyond => {
            Some(WallLink { weight: 2.0 * number, ..at_box(face, wall, velocity[axis]) })
        }
        _ => None,
    }
}

/// A link to a wall of the box.
fn at_box((face, axis): (u32, u8), wall: (u8, u8), velocity: f64) -> WallLink {
    WallLink { face, axis, solid: NONE, wall, weight: 0.0, velocity, arm: [0.0; 6], free: NONE }
}

/// Number of a solid among the bodies that are free, or [`NONE`].
fn free_number<const D: usize>(step: &ViscousStep<D>, solid: usize) -> u32 {
    let Some(index) = solid.checked_sub(step.fractions.at_rest.len()) else { return NONE };
    if !step.bodies[index].is_free() {
        return NONE;
    }
    step.bodies[..index].iter().filter(|body| body.is_free()).count() as u32
}
