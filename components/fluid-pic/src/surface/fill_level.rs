//! Distance to the free surface, from how full the surroundings of a cell are.
//!
//! The mass of particles is spread over cells by the hat of width `h`. Of a full half space whose
//! plane surface lies at distance `d` (in edges of cells, positive if the cell's centre is wet),
//! the share of the hat that is full is
//!
//! ```text
//! f = 1/2 + d - d |d| / 2         so         d = +-(1 - sqrt(1 - 2 |f - 1/2|))
//! ```
//!
//! for surfaces along the axes, and nearly so for others. Where walls or bodies take room, `f` is
//! the share of what room is left. A drop or a film of which no cell is half full is no pressure's
//! concern: it flies, or lies on its wall.

use crate::grid::staggered_grid::StaggeredGrid;

/// Room that is too little to judge from [cells].
pub const LITTLE: f64 = 0.02;

/// Share of the hat about each cell that is room for fluid: open fractions, spread by the hat.
pub fn room<const D: usize>(
    grid: &StaggeredGrid<D>,
    volume: &[f64],
    room: &mut Vec<f64>,
    work: &mut Vec<f64>,
) {
    room.clear();
    room.extend_from_slice(volume);
    for a in 0..D {
        work.clear();
        work.extend_from_slice(room);
        let stride = grid.stride[a];
        for at in stride..grid.stored - stride {
            room[at] = 0.125 * (work[at - stride] + work[at + stride]) + 0.75 * work[at];
        }
    }
    grid.ghosts.fill(room);
}

/// Distance of a cell's centre from the surface in edges of cells, positive inside the fluid, from
/// the mass about it relative to that of a full cell, and the room.
#[inline]
pub fn depth(mass: f64, room: f64) -> f64 {
    if room < LITTLE {
        return -1.0;
    }
    let over = (mass / room).clamp(0.0, 1.0) - 0.5;
    (1.0 - (1.0 - 2.0 * over.abs()).sqrt()) * over.signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_that_of_a_plane_surface() {
        for d in [-0.9, -0.5, -0.1, 0.0, 0.3, 0.7, 0.99_f64] {
            let full = 0.5 + d - 0.5 * d * d.abs();
            assert!((depth(full, 1.0) - d).abs() < 1e-12);
            assert!((depth(0.4 * full, 0.4) - d).abs() < 1e-12);
        }
        assert_eq!(depth(0.0, 0.0), -1.0);
    }
}
