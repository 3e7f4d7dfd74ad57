//! The coarser equation of pairs of cells.
//!
//! Fluxes between coarse cells are sums of the fine ones over twice the distance, so couplings add
//! up and are divided by the ratio of the edges. What couples a cell to air ends where the surface
//! is, at distance `1 / coupling` of the fine cell's centre; the coarse cell's centre lies half a
//! fine cell farther away.

use crate::grid::periodic_ghosts::PeriodicGhosts;
use crate::grid::staggered_grid::{room, storage};
use crate::pressure::stencil::Stencil;

/// Cells of a level of a grid, and the cells of which one of the next level is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelShape<const D: usize> {
    /// Cells along each axis.
    pub cells: [usize; D],
    /// Cells for which there is room, an even number where pairs are made. Those beyond `cells`
    /// take no part.
    pub room: [usize; D],
    /// Steps in memory.
    pub stride: [usize; D],
    /// Stored cells, with a layer of ghosts.
    pub stored: usize,
    /// Cells along each axis of one of the next level: 1 or 2.
    pub pair: [usize; D],
    /// Axes that wrap around.
    pub periodic: [bool; D],
}

impl<const D: usize> LevelShape<D> {
    /// Of a number of cells along each axis, stored as a grid is.
    pub fn new(cells: [usize; D], periodic: [bool; D]) -> Self {
        let pair = cells.map(|n| if n > 1 { 2 } else { 1 });
        Self { pair, periodic, ..Self::stored_as(cells, cells.map(room)) }
    }

    /// True if the last cell along an axis that wraps around makes no pair: it has the first cell
    /// as its neighbour. Nothing is interpolated from one to the other.
    pub fn has_seam(&self, axis: usize) -> bool {
        self.periodic[axis] && self.pair[axis] == 2 && self.cells[axis] % 2 == 1
    }

    /// Place of the cell below one along an axis: at the other end, if the axis wraps around.
    #[inline]
    pub fn below(&self, axis: usize, place: usize) -> usize {
        let stride = self.stride[axis];
        let is_first = place / stride % (self.room[axis] + 2) == 1;
        if self.periodic[axis] && is_first {
            place + (self.cells[axis] - 1) * stride
        } else {
            place - stride
        }
    }

    /// True if a place is beyond the last cell along an axis.
    #[inline]
    fn is_padding(&self, place: usize) -> bool {
        (0..D).any(|a| place / self.stride[a] % (self.room[a] + 2) > self.cells[a])
    }

    /// Ghosts that stand for cells at the other end, along axes that `wraps`.
    pub fn ghosts(&self, wraps: impl Fn(usize) -> bool) -> PeriodicGhosts {
        let along = std::array::from_fn(|a| self.periodic[a] && wraps(a));
        PeriodicGhosts::new(self.cells, self.room, along)
    }

    /// Of a number of cells, with room for as many as said.
    pub fn stored_as(cells: [usize; D], room: [usize; D]) -> Self {
        let (stride, stored) = storage(room);
        Self { cells, room, stride, stored, pair: [1; D], periodic: [false; D] }
    }

    /// The next level's.
    pub fn coarser(&self) -> Self {
        Self::new(std::array::from_fn(|a| self.cells[a].div_ceil(self.pair[a])), self.periodic)
    }

    /// Stored cells of a row.
    #[inline]
    pub fn row_length(&self) -> usize {
        self.room[0] + 2
    }

    /// Place of the ghost cell at which the row of a cell begins.
    #[inline]
    pub fn row_start(&self, at: [isize; D]) -> usize {
        (1..D).map(|a| (at[a] + 1) as usize * self.stride[a]).sum()
    }

    /// Place in memory of the coarse cell of which a cell is a child.
    #[inline]
    pub fn parent(&self, coarse: &Self, place: usize) -> usize {
        let mut rest = place;
        let mut parent = 0;
        for a in (0..D).rev() {
            let at = rest / self.stride[a];
            rest %= self.stride[a];
            parent += ((at - 1) / self.pair[a] + 1) * coarse.stride[a];
        }
        parent
    }

    /// Place in memory of a coarse cell's first child, in a level whose coarser one is `coarse`.
    #[inline]
    pub fn first_child(&self, coarse: &Self, place: usize) -> usize {
        let mut rest = place;
        let mut child = 0;
        for a in (0..D).rev() {
            let at = rest / coarse.stride[a];
            rest %= coarse.stride[a];
            child += ((at - 1) * self.pair[a] + 1) * self.stride[a];
        }
        child
    }

    /// Steps in memory from a coarse cell's first child to all of its children.
    pub fn children(&self) -> Vec<usize> {
        let count: usize = self.pair.iter().product();
        let step = |mut number: usize| {
            (0..D).fold(0, |sum, a| {
                let along = number % self.pair[a];
                number /= self.pair[a];
                sum + along * self.stride[a]
            })
        };
        (0..count).map(step).collect()
    }
}

/// Fills the coefficients of a coarser level. `held` couples the fine cells to air, as
/// [`held_by_air`] has it, and `full` is the coupling of an open fine face.
pub fn coarsen<const D: usize>(
    fine_shape: &LevelShape<D>,
    fine: &Stencil<f32, D>,
    held: &[f32],
    full: f32,
    shape: &LevelShape<D>,
    coarse: &mut Stencil<f32, D>,
) {
    let children = fine_shape.children();
    coarse.diagonal.fill(0.0);
    coarse.coupling.iter_mut().for_each(|coupling| coupling.fill(0.0));
    let may_pad = (0..D).any(|a| fine_shape.has_seam(a));
    let is_child = |at: usize| !may_pad || !fine_shape.is_padding(at);
    let is_active = |at: usize| fine.diagonal[at] > 0.0 && is_child(at);
    for (place, first) in cells_and_children(shape, fine_shape) {
        let mut to_surface = 0.0;
        for &child in &children {
            let at = first + child;
            if is_active(at) {
                to_surface += to_air(fine_shape, fine, (held[at], full), at, child);
            }
        }
        for a in 0..D {
            let lowest = children.iter().filter(|&&child| {
                (child / fine_shape.stride[a]).is_multiple_of(fine_shape.room[a] + 2)
            });
            let inside = lowest.map(|child| first + child).filter(|&at| is_child(at));
            let sum: f32 = inside.map(|at| fine.coupling[a][at]).sum();
            coarse.coupling[a][place] = sum / fine_shape.pair[a] as f32;
        }
        coarse.diagonal[place] = to_surface;
    }
    let Stencil { coupling, ghosts, .. } = &mut *coarse;
    coupling.iter_mut().for_each(|coupling| ghosts.fill(coupling));
    for (place, _) in cells_and_children(shape, fine_shape) {
        let mut sum = 0.0;
        for a in 0..D {
            sum += coarse.coupling[a][place] + coarse.coupling[a][place + shape.stride[a]];
        }
        coarse.diagonal[place] += sum;
    }
    coarse.find_rows(shape.row_length());
}

/// Coupling of a cell to air, as its coarse cell feels it. Air lies where neighbours take no part:
/// the surface is nearer to the coarse cell's centre, by half a cell, where that neighbour is of
/// the same coarse cell, and else as much farther away.
fn to_air<const D: usize>(
    shape: &LevelShape<D>,
    fine: &Stencil<f32, D>,
    (held, full): (f32, f32),
    at: usize,
    child: usize,
) -> f32 {
    let held = held / full;
    if held == 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for a in 0..D {
        let is_upper = child / shape.stride[a] % (shape.room[a] + 2) == 1;
        for (beyond, is_above) in [(at - shape.stride[a], false), (at + shape.stride[a], true)] {
            if fine.diagonal[beyond] > 0.0 {
                continue;
            }
            let is_inside = shape.pair[a] == 2 && is_above != is_upper;
            let farther = match (shape.pair[a], is_inside) {
                (2, true) => -0.5,
                (2, false) => 0.5,
                _ => 0.0,
            };
            sum += full / (1.0 / held + farther).max(NEAREST);
        }
    }
    sum
}

/// Least distance of a surface from a coarse cell's centre, in edges of fine cells.
const NEAREST: f32 = 0.25;

/// What couples a cell to air, over the number of its neighbours that take no part.
pub fn held_by_air<const D: usize>(stencil: &Stencil<f32, D>, at: usize) -> f32 {
    let (mut inner, mut outside) = (0.0, 0);
    for a in 0..D {
        let stride = stencil.stride[a];
        inner += stencil.coupling[a][at] + stencil.coupling[a][at + stride];
        for beyond in [at - stride, at + stride] {
            outside += usize::from(stencil.diagonal[beyond] <= 0.0);
        }
    }
    let rest = stencil.diagonal[at] - inner;
    // Less than that is rounding.
    if rest > 1e-5 * stencil.diagonal[at] { rest / outside.max(1) as f32 } else { 0.0 }
}

/// Places of all cells but ghosts, and of the first child of each in the finer level.
fn cells_and_children<const D: usize>(
    shape: &LevelShape<D>,
    fine: &LevelShape<D>,
) -> impl Iterator<Item = (usize, usize)> + use<D> {
    let (shape, fine) = (*shape, *fine);
    let [cells, pair] = [shape.cells[0], fine.pair[0]];
    (0..shape.cells[1..].iter().product::<usize>()).flat_map(move |mut number| {
        let mut place = 1;
        for a in 1..D {
            place += (number % shape.cells[a] + 1) * shape.stride[a];
            number /= shape.cells[a];
        }
        let first = fine.first_child(&shape, place);
        (0..cells).map(move |along| (place + along, first + pair * along))
    })
}
