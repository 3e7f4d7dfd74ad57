//! Velocities of faces in solids that let the fluid slip.
//!
//! What is extrapolated from the fluid into a solid says nothing of the solid's motion: particles
//! beside it would drift into it, or stay behind it, and take momentum along. So the part along the
//! solid's normal is that of the solid (Batty, Bertails & Bridson, *ACM Trans. Graphics* 26 (2007)
//! 100), and the fluid slips along it. A slope that held its covered faces instead would hold the
//! fluid back like stairs.

use crate::grid::staggered_grid::StaggeredGrid;
use crate::particles::from_grid::FaceVelocity;
use crate::pressure::body_coupling::Wrench;
use crate::solids::open_fractions::OpenFractions;
use crate::solids::rigid_body::{RigidBody, cross, padded};
use crate::solver::pressure_gradient::CREVICE;

/// Faces in solids, and their velocities.
#[derive(Clone, Debug)]
pub struct SlipFaces<const D: usize> {
    /// Those in solids at rest.
    at_rest: Vec<SlipFace<D>>,
    /// Axis, cell and velocity [m/s] of those in one kind of solids.
    found: Vec<(u8, u32, f64)>,
}

/// A face in a solid: the lower one of a cell across an axis.
#[derive(Clone, Copy, Debug)]
struct SlipFace<const D: usize> {
    axis: u8,
    cell: u32,
    /// Outward, of the solid that is nearest.
    normal: [f64; D],
    /// Number of that solid.
    solid: u32,
    /// Centre of the face, as that solid sees it [m].
    centre: [f64; D],
}

impl<const D: usize> SlipFaces<D> {
    /// Of the solids at rest.
    pub fn new(grid: &StaggeredGrid<D>, fractions: &OpenFractions<D>) -> Self {
        let mut at_rest = Vec::new();
        for pairs in fractions.near_rest().chunk_by(|a, b| a.0 == b.0) {
            at_rest.extend(faces_of_cell(grid, (fractions, &[]), pairs));
        }
        Self { at_rest, found: Vec::new() }
    }

    /// True if no solid is in the fluid.
    pub fn is_empty(&self, fractions: &OpenFractions<D>) -> bool {
        self.at_rest.is_empty() && fractions.near_solids().is_empty()
    }

    /// Gives the faces in solids the solids' velocities along their normals. `motions` are those of
    /// the bodies.
    pub fn constrain(
        &mut self,
        grid: &StaggeredGrid<D>,
        (fractions, bodies): (&OpenFractions<D>, &[RigidBody<D>]),
        motions: &[Wrench],
        velocity: &mut FaceVelocity<D>,
    ) {
        let Self { at_rest, found } = self;
        for face in &*at_rest {
            found.push(face.slipping(grid, velocity, [0.0; D]));
        }
        set_found(found, velocity);
        for pairs in fractions.near_solids().chunk_by(|a, b| a.0 == b.0) {
            for face in faces_of_cell(grid, (fractions, bodies), pairs) {
                let number = face.solid as usize;
                let (body, motion) =
                    (fractions.solid(bodies, number), &motions[number - fractions.at_rest.len()]);
                let arm = padded::<D>(std::array::from_fn(|k| face.centre[k] - body.centre[k]));
                let turn = cross([motion[3], motion[4], motion[5]], arm);
                let solid = std::array::from_fn(|b| motion[b] + turn[b]);
                found.push(face.slipping(grid, velocity, solid));
            }
        }
        set_found(found, velocity);
    }
}

impl<const D: usize> SlipFace<D> {
    /// The face's velocity, once the fluid's along the normal is that of the solid.
    fn slipping(
        &self,
        grid: &StaggeredGrid<D>,
        velocity: &FaceVelocity<D>,
        solid: [f64; D],
    ) -> (u8, u32, f64) {
        let (a, at) = (self.axis as usize, self.cell as usize);
        let below = at - grid.stride[a];
        let mut over = 0.0;
        for b in 0..D {
            let own = &velocity[b];
            let fluid = if a == b {
                own[at]
            } else {
                let up = grid.stride[b];
                0.25 * (own[at] + own[at + up] + own[below] + own[below + up])
            };
            over += (fluid - solid[b]) * self.normal[b];
        }
        (self.axis, self.cell, velocity[a][at] - over * self.normal[a])
    }
}

/// Takes the velocities over.
fn set_found<const D: usize>(found: &mut Vec<(u8, u32, f64)>, velocity: &mut FaceVelocity<D>) {
    for (axis, cell, value) in found.drain(..) {
        velocity[axis as usize][cell as usize] = value;
    }
}

/// Lower faces of a cell that lie in the solids near it. `pairs` are of the cell and each of them.
fn faces_of_cell<'a, const D: usize>(
    grid: &'a StaggeredGrid<D>,
    (fractions, bodies): (&'a OpenFractions<D>, &'a [RigidBody<D>]),
    pairs: &'a [(u32, u32)],
) -> impl Iterator<Item = SlipFace<D>> + 'a {
    let cell = pairs[0].0;
    let (at, cell_at) = (cell as usize, grid.cell_at(cell as usize));
    // A body may reach beyond the box.
    let is_in_box = (0..D).all(|a| (0..grid.cells[a] as isize).contains(&cell_at[a]));
    let is_slipping = move |a: &usize| {
        is_in_box && fractions.open[*a][at] < CREVICE && !fractions.is_wall(*a, at)
    };
    (0..D).filter(is_slipping).filter_map(move |a| {
        let centre = grid.face_centre(a, cell_at);
        let reach = 2.0 * grid.spacing;
        let seen_by = |&(_, solid): &(u32, u32)| {
            let (body, centre) = fractions.seen_by(grid, bodies, solid as usize, centre);
            let (height, normal) = body.height(centre, reach)?;
            Some((height, SlipFace { axis: a as u8, cell, normal, solid, centre }))
        };
        let nearest = pairs.iter().filter_map(seen_by).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, face)| face)
    })
}
