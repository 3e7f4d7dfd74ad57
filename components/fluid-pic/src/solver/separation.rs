//! Fluid lets go of solids: it is not held to them by suction where air can come in between.
//!
//! ```text
//! beside a solid, next to air:   p >= 0,   div u >= 0,   p div u = 0
//! ```
//!
//! (Batty, Bertails & Bridson, *ACM Trans. Graph.* 26 (2007) 100). A cell beside a solid whose
//! pressure is negative, and that air reaches directly or through such cells, counts as air from
//! then on: its pressure is zero. It counts as fluid again as soon as fluid gathers in it.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::StaggeredGrid;
use crate::solids::open_fractions::OpenFractions;
use crate::surface::fill_level::LITTLE;

/// Depth of a cell that was let go [cells].
pub const LET_GO: f64 = -1e-3;
/// Open part of a face below which its cells are beside a solid.
const BESIDE: f64 = 0.999;

/// Cells that solids have let go of.
#[derive(Clone, Debug, Default)]
pub struct Separation {
    /// Cells that count as air, in the order in which they were found.
    pub cells: Vec<u32>,
    front: Vec<u32>,
}

impl Separation {
    /// Finds further cells, given the pressure of the wet ones, and makes them air. True if there
    /// are any.
    pub fn find<const D: usize>(
        &mut self,
        (grid, near): (&StaggeredGrid<D>, &NearRows),
        fractions: &OpenFractions<D>,
        (q, room): (&[f64], &[f64]),
        depth: &mut [f64],
    ) -> bool {
        let before = self.cells.len();
        let pulls = |at: usize, depth: &[f64]| {
            depth[at] > 0.0 && q[at] < 0.0 && is_beside_a_solid(grid, fractions, at)
        };
        self.front.clear();
        for at in near.cells() {
            if pulls(at, depth) && is_beside_air(grid, fractions, (depth, room), at) {
                self.front.push(at as u32);
            }
        }
        while let Some(at) = self.front.pop() {
            let at = at as usize;
            if depth[at] <= 0.0 {
                continue;
            }
            depth[at] = LET_GO;
            self.cells.push(at as u32);
            for a in 0..D {
                let stride = grid.stride[a];
                for (face, beyond) in [(at, at - stride), (at + stride, at + stride)] {
                    let beyond = grid.place_inside(beyond);
                    if fractions.open[a][face] > 0.0 && pulls(beyond, depth) {
                        self.front.push(beyond as u32);
                    }
                }
            }
        }
        grid.ghosts.fill(depth);
        self.cells.len() > before
    }

    /// Makes all of them air in depths that do not know of them.
    pub fn let_go<const D: usize>(&self, grid: &StaggeredGrid<D>, depth: &mut [f64]) {
        self.cells.iter().for_each(|&at| depth[at as usize] = LET_GO);
        grid.ghosts.fill(depth);
    }

    /// Makes the cells air again that were so in the last step, as far as they still are wet, and
    /// `gathers` says nothing else.
    pub fn keep(&mut self, depth: &mut [f64], gathers: impl Fn(usize) -> bool) {
        self.cells.retain(|&at| {
            let at = at as usize;
            let stays = depth[at] > 0.0 && !gathers(at);
            if stays {
                depth[at] = LET_GO;
            }
            stays
        });
    }
}

fn is_beside_a_solid<const D: usize>(
    grid: &StaggeredGrid<D>,
    fractions: &OpenFractions<D>,
    at: usize,
) -> bool {
    (0..D)
        .any(|a| fractions.open[a][at] < BESIDE || fractions.open[a][at + grid.stride[a]] < BESIDE)
}

fn is_beside_air<const D: usize>(
    grid: &StaggeredGrid<D>,
    fractions: &OpenFractions<D>,
    (depth, room): (&[f64], &[f64]),
    at: usize,
) -> bool {
    (0..D).any(|a| {
        let stride = grid.stride[a];
        let beside = [(at, at - stride), (at + stride, at + stride)];
        beside.into_iter().any(|(face, beyond)| {
            fractions.open[a][face] > 0.0
                && fractions.volume[beyond] > 0.0
                && depth[beyond] <= 0.0
                && room[beyond] >= LITTLE
        })
    })
}
