//! Orientation of the lattice: the axes of the world along which its own lie.
//!
//! Cells are stored in rows along the lattice's first axis. A row that ends inside a line of the
//! memory leaves that line in pieces, which costs several times what a whole line does. So the
//! lattice is turned until few lines are in pieces: of a bore, until rows lie along its axis.
//! [`crate::LbmFluid`] turns what it is given and turns back what it tells; nothing else knows of
//! it. The turns are the three even ones, about the diagonal, which keep right hands right.
//!
//! Vectors are put in another order, which changes no bit of them. Frames of parts keep their own
//! axes, so that their poses are turned by a quaternion.

use crate::lattice::d3q19::{C, Q};
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::survey::static_geometry::{GridAxes, StaticGeometry};

mod scene;

/// Of the time that lines take with rows along x, what they may take at most with rows along
/// another axis for the lattice to be turned.
const WORTH_IT: f64 = 0.9;

/// Extra time of a line in pieces over a whole one, in times of a whole one, as mean of both kinds
/// of steps. In odd steps it takes some 700 cycles rather than 190, in even steps no more.
const PIECES: f64 = 1.4;

/// Axes of the world along which the lattice's lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LatticeOrientation {
    /// The world's axis along which rows lie; the others follow in cyclic order.
    first: usize,
}

impl LatticeOrientation {
    /// The world's own.
    pub const WORLD: Self = Self { first: 0 };

    /// Those by which the fewest lines of `line` cells are in pieces; the world's own, unless
    /// others are much better.
    pub fn with_whole_lines(ground: &StaticGeometry, line: usize) -> Self {
        let solid = &ground.voxels.obstacles.solid;
        let of = |first| {
            let [lines, in_pieces] = Self { first }.lines(&ground.grid, solid, line);
            lines as f64 + PIECES * in_pieces as f64
        };
        let [x, y, z] = [0, 1, 2].map(of);
        let (first, least) = if y <= z { (1, y) } else { (2, z) };
        if least <= WORTH_IT * x { Self { first } } else { Self::WORLD }
    }

    /// Lines that the cells which are not solid make, and those of them in which a row ends or
    /// begins, but not with the line.
    fn lines(self, grid: &Grid, solid: &[u16], line: usize) -> [usize; 2] {
        let n = grid.n.map(|n| n as usize);
        let steps = self.to_lattice(&[1, n[0], n[0] * n[1]]);
        let [columns, rows, layers] = self.to_lattice(&n);
        // A line counts when its first inner end is met: those of one line come one after the
        // other.
        let (mut cells, mut in_pieces, mut last) = (0_usize, 0, usize::MAX);
        for start in (0..layers).flat_map(|k| (0..rows).map(move |j| j * steps[1] + k * steps[2])) {
            let mut was_fluid = false;
            for is_fluid in (0..columns).map(|i| solid[start + i * steps[0]] == 0).chain([false]) {
                if is_fluid != was_fluid && !cells.is_multiple_of(line) && last != cells / line {
                    last = cells / line;
                    in_pieces += 1;
                }
                cells += usize::from(is_fluid);
                was_fluid = is_fluid;
            }
        }
        [cells.div_ceil(line), in_pieces]
    }

    /// The axis of the lattice that one of the world is.
    pub fn axis_to_lattice(self, axis: usize) -> usize {
        (axis + 3 - self.first) % 3
    }

    /// The same for a box of cells.
    pub fn grid_axes(self) -> GridAxes {
        let order = [0, 1, 2].map(|axis| self.axis_to_lattice(axis));
        GridAxes { order, upright: self.turn([0.0, 0.0, 0.0, 1.0]) }
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

#[cfg(test)]
mod tests;
