//! Velocities of faces in bodies, and beyond walls, that hold the fluid back.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::solids::open_fractions::{NONE, OpenFractions};
use crate::solids::rigid_body::RigidBody;
use crate::solver::pic_settings::{BoxWall, PicSettings};

/// Gives one component of a velocity to the faces in bodies, and beyond walls, that hold the fluid
/// back.
pub(super) fn hold<const D: usize>(
    (grid, near): (&StaggeredGrid<D>, &NearRows),
    fractions: &OpenFractions<D>,
    settings: &PicSettings<D>,
    bodies: &[RigidBody<D>],
    axis: usize,
    velocity: &mut [f64],
) {
    if !settings.sticks() || settings.viscosity == 0.0 {
        return;
    }
    if settings.bodies_stick {
        for at in near.cells() {
            let holder = fractions.holder[axis][at];
            if holder != NONE {
                let centre = grid.face_centre(axis, grid.cell_at(at));
                let (body, centre) = fractions.seen_by(grid, bodies, holder as usize, centre);
                velocity[at] = body.velocity_at(centre)[axis];
            } else if at >= grid.stride[axis] && fractions.is_shut(axis, at, at - grid.stride[axis])
            {
                // A wall thinner than a cell holds no face's centre.
                velocity[at] = 0.0;
            }
        }
    }
    for b in (0..D).filter(|&b| b != axis) {
        for side in 0..2 {
            let BoxWall::Stick(wall) = settings.walls[b][side] else { continue };
            let last = [0, grid.cells[b] as isize - 1][side];
            for at in near.cells().filter(|&at| grid.cell_at(at)[b] == last) {
                let beyond = if side == 0 { at - grid.stride[b] } else { at + grid.stride[b] };
                velocity[beyond] = 2.0 * wall[axis] - velocity[at];
            }
        }
    }
}
