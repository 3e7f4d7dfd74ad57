//! Velocities beyond the fluid: means of neighbours, layer by layer.

use crate::grid::staggered_grid::StaggeredGrid;

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

/// Fills `layers` of unknown faces around the known ones, one after the other, with the mean of
/// their known neighbours of the same axis.
pub fn extrapolate<const D: usize>(
    grid: &StaggeredGrid<D>,
    layers: usize,
    state: &mut [FaceState],
    velocity: &mut [f64],
    found: &mut Vec<(u32, f64)>,
) {
    let row = if D > 1 { grid.stride[1] } else { grid.stored };
    for _ in 0..layers {
        found.clear();
        for start in (0..grid.stored).step_by(row) {
            for along in 0..row {
                let at = start + along;
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
                if along + 1 < row {
                    add(at + 1);
                }
                for a in 1..D {
                    let (stride, position) = (grid.stride[a], at / grid.stride[a]);
                    let rows =
                        if a + 1 < D { grid.stride[a + 1] / stride } else { grid.stored / stride };
                    let along = position % rows;
                    if along > 0 {
                        add(at - stride);
                    }
                    if along + 1 < rows {
                        add(at + stride);
                    }
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
    }
}
