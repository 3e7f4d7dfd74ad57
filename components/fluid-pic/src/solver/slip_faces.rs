//! Velocities of faces in solids that let the fluid slip.
//!
//! What is extrapolated from the fluid into a solid says nothing of the solid's motion: particles
//! beside it would drift into it, or stay behind it, and take momentum along. So the part along the
//! solid's normal is that of the solid (Batty, Bertails & Bridson, *ACM Trans. Graphics* 26 (2007)
//! 100), and the fluid slips along it.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::from_grid::FaceVelocity;
use crate::pressure::body_coupling::Wrench;
use crate::solids::open_fractions::OpenFractions;
use crate::solids::rigid_body::{RigidBody, cross, padded};
use crate::solver::pressure_gradient::CREVICE;

/// Faces in solids, and their velocities.
#[derive(Clone, Debug, Default)]
pub struct SlipFaces {
    /// Axis, cell and velocity [m/s].
    found: Vec<(u8, u32, f64)>,
}

impl SlipFaces {
    /// Gives the faces in solids the solids' velocities along their normals. `motions` are those of
    /// the bodies.
    pub fn constrain<const D: usize>(
        &mut self,
        grid: &StaggeredGrid<D>,
        (fractions, bodies): (&OpenFractions<D>, &[RigidBody<D>]),
        motions: &[Wrench],
        velocity: &mut FaceVelocity<D>,
    ) {
        self.found.clear();
        let reach = 2.0 * grid.spacing;
        for &(cell, number) in fractions.near_solids() {
            let (at, number) = (cell as usize, number as usize);
            let motion = &motions[number - fractions.at_rest.len()];
            let cell_at = grid.cell_at(at);
            // A body may reach beyond the box.
            if (0..D).any(|a| !(0..grid.cells[a] as isize).contains(&cell_at[a])) {
                continue;
            }
            for a in 0..D {
                let below = at - grid.stride[a];
                if fractions.open[a][at] >= CREVICE || fractions.is_wall(a, at, below) {
                    continue;
                }
                let centre = grid.face_centre(a, cell_at);
                let (body, seen) = fractions.seen_by(grid, bodies, number, centre);
                let Some((_, normal)) = body.height(seen, reach) else { continue };
                let arm = padded::<D>(std::array::from_fn(|k| seen[k] - body.centre[k]));
                let turn = cross([motion[3], motion[4], motion[5]], arm);
                let mut over = 0.0;
                for b in 0..D {
                    let own = &velocity[b];
                    let fluid = if a == b {
                        own[at]
                    } else {
                        let up = grid.stride[b];
                        0.25 * (own[at] + own[at + up] + own[below] + own[below + up])
                    };
                    over += (fluid - motion[b] - turn[b]) * normal[b];
                }
                self.found.push((a as u8, cell, velocity[a][at] - over * normal[a]));
            }
        }
        for &(axis, cell, value) in &self.found {
            velocity[axis as usize][cell as usize] = value;
        }
    }
}
