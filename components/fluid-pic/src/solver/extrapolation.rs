//! Velocities beyond the fluid: means of neighbours, layer by layer.

use crate::grid::near_rows::NearRows;
use crate::grid::staggered_grid::{GHOST, StaggeredGrid};

/// Knowledge of the velocity of a face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FaceState {
    /// It follows from those of its neighbours.
    #[default]
    Unknown,
    /// The fluid's.
    Fluid,
    /// That of a wall of the domain, which says nothing about the fluid beside it.
    Wall,
}

/// Room to work in.
#[derive(Clone, Debug, Default)]
pub struct ExtrapolationRoom {
    /// Faces of a layer, and their velocities.
    found: Vec<(u32, f64)>,
    /// Rows that have faces of the fluid.
    has_fluid: Vec<bool>,
}

/// Fills `layers` of unknown faces around the known ones, one after the other, with the mean of
/// their known neighbours of the same axis.
pub fn extrapolate<const D: usize>(
    grid: &StaggeredGrid<D>,
    near: &NearRows,
    layers: usize,
    state: &mut [FaceState],
    velocity: &mut [f64],
    room: &mut ExtrapolationRoom,
) {
    let length = grid.row_length();
    for _ in 0..layers {
        let ExtrapolationRoom { found, has_fluid } = room;
        found.clear();
        has_fluid.clear();
        has_fluid.resize(grid.stored / length, false);
        // A sum over the row, unlike a search, is done for many faces at once.
        for span in near.spans() {
            let any = |any: u8, &state: &FaceState| any | u8::from(state == FaceState::Fluid);
            has_fluid[span.start / length] = state[span.clone()].iter().fold(0_u8, any) != 0;
        }
        let is_known = |start: usize| has_fluid[start / length];
        for span in near.spans() {
            let start = span.start / length * length;
            let (rows, count_of_rows) = rows_beside(grid, start);
            let beside = &rows[..count_of_rows];
            if !is_known(start) && !beside.iter().any(|&row| is_known(row)) {
                continue;
            }
            for at in span {
                let along = at - start;
                if state[at] != FaceState::Unknown {
                    continue;
                }
                let (mut sum, mut count) = (0.0, 0);
                let mut add = |other: usize| {
                    if state[other] == FaceState::Fluid {
                        sum += velocity[other];
                        count += 1;
                    }
                };
                if along > 0 {
                    add(at - 1);
                }
                if along + 1 < length {
                    add(at + 1);
                }
                for row in beside {
                    add(row + along);
                }
                if count > 0 {
                    found.push((at as u32, sum / f64::from(count)));
                }
            }
        }
        for &(at, value) in found.iter() {
            velocity[at as usize] = value;
            state[at as usize] = FaceState::Fluid;
        }
        grid.ghosts.fill(velocity);
        grid.ghosts.fill(state);
    }
}

/// Starts of the rows beside that which begins at `start`, along the axes across it, and their
/// number.
fn rows_beside<const D: usize>(grid: &StaggeredGrid<D>, start: usize) -> ([usize; 4], usize) {
    let at = grid.cell_at(start);
    let (mut rows, mut count) = ([0; 4], 0);
    for a in 1..D {
        let stride = grid.stride[a];
        let end = if a + 1 < D { grid.stride[a + 1] } else { grid.stored };
        let position = (at[a] + GHOST as isize) as usize;
        if position > 0 {
            rows[count] = start - stride;
            count += 1;
        }
        if (position + 1) * stride < end {
            rows[count] = start + stride;
            count += 1;
        }
    }
    (rows, count)
}
