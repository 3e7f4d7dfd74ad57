//! Which axes of the world the lattice's are.
//!
//! Cells are stored in rows along the lattice's first axis, and a row's ends cost several times what cells inside it do.
//! So the lattice is turned until its rows lie along the longest way through the fluid: of a bore, along its axis.
//! [`crate::FluidLbm`] turns what it is given and turns back what it tells; nothing else knows of it. The turns
//! are the three even ones, about the diagonal, which keep right hands right.
//!
//! Vectors are put in another order, which changes no bit of them. Frames of parts keep their own axes, so that their poses
//! are turned by a quaternion.

use crate::grid::Grid;
use crate::ground::Ground;
use crate::lattice::{C, Q};

mod results;
mod scene;

/// Of the number of rows along x, what those along another axis may be at most for the lattice to be turned.
const WORTH_IT: f64 = 0.9;

/// Which axes of the world the lattice's are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes {
    /// The world's axis along which rows lie; the others follow in cyclic order.
    first: usize,
}

impl Axes {
    /// The world's own.
    pub const WORLD: Self = Self { first: 0 };

    /// Those along which the stored cells lie in the fewest rows; the world's own, unless others are much better.
    pub fn with_long_rows(ground: &Ground) -> Self {
        let solid = &ground.voxels.obstacles.solid;
        let [x, y, z] = [0, 1, 2].map(|axis| rows(&ground.grid, solid, axis));
        let (first, least) = if y <= z { (1, y) } else { (2, z) };
        if least as f64 <= WORTH_IT * x as f64 { Self { first } } else { Self::WORLD }
    }

    /// The axis of the lattice that one of the world is.
    pub fn axis_to_lattice(self, axis: usize) -> usize {
        (axis + 3 - self.first) % 3
    }

    /// The axis of the world that one of the lattice is.
    pub fn axis_to_world(self, axis: usize) -> usize {
        (axis + self.first) % 3
    }

    /// Three of anything, by axis of the lattice.
    pub fn to_lattice<T: Clone>(self, of_world: &[T; 3]) -> [T; 3] {
        std::array::from_fn(|axis| of_world[self.axis_to_world(axis)].clone())
    }

    /// Three of anything, by axis of the world.
    pub fn to_world<T: Clone>(self, of_lattice: &[T; 3]) -> [T; 3] {
        std::array::from_fn(|axis| of_lattice[self.axis_to_lattice(axis)].clone())
    }

    /// The unit quaternion `(x, y, z, w)` of a frame in the lattice, given that in the world.
    pub fn turn(self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        // By the quaternion (s, s, s, 1)/2, s the sign of the third of a turn about the diagonal.
        let s = match self.first {
            0 => return [x, y, z, w],
            1 => -0.5,
            _ => 0.5,
        };
        [
            0.5 * x + s * (w + (z - y)),
            0.5 * y + s * (w + (x - z)),
            0.5 * z + s * (w + (y - x)),
            0.5 * w - s * (x + (y + z)),
        ]
    }

    /// The direction of the lattice that one of the world is.
    pub fn direction_to_lattice(self, i: usize) -> usize {
        let c = self.to_lattice(&C[i]);
        (0..Q).find(|&k| C[k] == c).unwrap_or_default()
    }
}

/// How many rows the cells that are not solid make along an axis.
fn rows(grid: &Grid, solid: &[u16], axis: usize) -> usize {
    let [nx, ny, _] = grid.n.map(|n| n as usize);
    let back = [1, nx, nx * ny][axis];
    let is_fluid = |index: usize| solid[index] == 0;
    let begins =
        |&index: &usize| is_fluid(index) && (grid.at(index)[axis] == 0 || !is_fluid(index - back));
    (0..grid.len()).filter(begins).count()
}

#[cfg(test)]
mod tests;
