//! The gas at any point of a regular grid, as observers see it.

use crate::gas::gas_law::{GasState, MOST_FIELDS};
use crate::grid::block_tree::{BlockAddress, NONE};
use crate::solver::wavelet_solver::WaveletSolver;

/// What is seen at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObservedPoint {
    /// Density, velocity, pressure.
    pub state: GasState,
    /// Level of the leaf in which it lies.
    pub level: u8,
    /// The body in which it lies, by its number.
    pub body: Option<u16>,
}

impl WaveletSolver {
    /// Points along each axis of the grid of a level, the upper faces left out.
    pub fn points_of_level(&self, level: u8) -> [usize; 3] {
        let shape = self.shape();
        std::array::from_fn(|a| self.tree.domain.blocks_along(level, a) as usize * shape.edge[a])
    }

    /// The gas at a point of the grid of a level: linear between the points of the finest block
    /// there that is not finer than the level.
    pub fn observed(&self, level: u8, at: [usize; 3]) -> ObservedPoint {
        let shape = self.shape();
        let (slot, place, part) = self.block_at(level, at);
        let (count, dims, gas) = (self.values.fields, shape.dims, &self.settings.gas);
        let field = |number: usize| {
            &self.values.padded[(slot * count + number) * shape.stored..][..shape.stored]
        };
        let mut fields = [0.0; MOST_FIELDS];
        for (number, value) in fields.iter_mut().enumerate().take(count) {
            let field = field(number);
            for corner in 0..1_usize << dims {
                let upper = |a: usize| corner >> a & 1;
                let weight: f64 = (0..dims)
                    .map(|a| if upper(a) == 1 { part[a] } else { 1.0 - part[a] })
                    .product();
                if weight > 0.0 {
                    let step: usize = (0..dims).map(|a| upper(a) * shape.stride[a]).sum();
                    *value += weight * field[place + step];
                }
            }
        }
        let nearest: usize = (0..dims).map(|a| usize::from(part[a] > 0.5) * shape.stride[a]).sum();
        let nearest = place + nearest;
        let marks = self.mask.of(&shape, slot);
        let body = marks.map_or(0, |marks| marks[nearest]).checked_sub(1);
        let state = gas.state(dims, &fields);
        ObservedPoint { state, level: self.leaf_level(slot, place), body }
    }

    /// Level of the leaf that holds a point of a block.
    fn leaf_level(&self, mut slot: usize, place: usize) -> u8 {
        let shape = self.shape();
        let inside = shape.at(place);
        let mut at: [usize; 3] = std::array::from_fn(|a| inside[a] - shape.ghosts[a]);
        while self.tree.children[slot][0] != NONE {
            let mut child = 0;
            for a in 0..shape.dims {
                let half = usize::from(2 * at[a] >= shape.edge[a]);
                at[a] = 2 * at[a] - half * shape.edge[a];
                child |= half << a;
            }
            slot = self.tree.children[slot][child] as usize;
        }
        self.tree.blocks[slot].level
    }

    /// The finest block that holds a point of the grid of a level, the place of the point of it
    /// below, and the part of the way to the next along each axis.
    fn block_at(&self, level: u8, at: [usize; 3]) -> (usize, usize, [f64; 3]) {
        let shape = self.shape();
        for own in (0..=level).rev() {
            let shift = level - own;
            let below = at.map(|x| x >> shift);
            let block = BlockAddress {
                level: own,
                at: std::array::from_fn(|a| (below[a] / shape.edge[a]) as u32),
            };
            let Some(slot) = self.tree.slot(block) else { continue };
            let inside = std::array::from_fn(|a| below[a] % shape.edge[a] + shape.ghosts[a]);
            let whole = f64::from(1_u32 << shift);
            let part = std::array::from_fn(|a| (at[a] - (below[a] << shift)) as f64 / whole);
            return (slot, shape.place(inside), part);
        }
        unreachable!("blocks of level 0 are always there")
    }
}
