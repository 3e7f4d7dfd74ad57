//! The tree of blocks: which exist, and who is whose neighbour, parent and child.
//!
//! Levels 0 and 1 are complete. A block has all of its children or none; its parent exists, and so
//! do all neighbours of its parent. Blocks lie in order of level, and of a level along a Morton
//! curve, so that neighbours in space are near in memory.

use crate::grid::block_shape::BlockShape;
use std::collections::{HashMap, HashSet};
use std::ops::Range;

/// Where there is no block.
pub const NONE: u32 = u32::MAX;

/// Spacing of the points of a level, from that of level 0 [m].
pub fn spacing_of_level(coarsest: f64, level: u8) -> f64 {
    coarsest * 0.5_f64.powi(i32::from(level))
}

/// Level and place of a block, in blocks of its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BlockAddress {
    /// Level, 0 for the coarsest.
    pub level: u8,
    /// Place along each axis.
    pub at: [u32; 3],
}

impl BlockAddress {
    /// The block that this one is a part of, on the level above.
    pub fn parent(self) -> Option<Self> {
        Some(Self { level: self.level.checked_sub(1)?, at: self.at.map(|x| x / 2) })
    }

    /// Number among its parent's children.
    pub fn number(self) -> usize {
        self.at.iter().enumerate().map(|(a, x)| (*x as usize & 1) << a).sum()
    }

    /// A child, by its number.
    pub fn child(self, shape: &BlockShape, number: usize) -> Self {
        let half = shape.half(number);
        let at =
            std::array::from_fn(
                |a| {
                    if a < shape.dims { 2 * self.at[a] + half[a] as u32 } else { 0 }
                },
            );
        Self { level: self.level + 1, at }
    }

    /// Place along a Morton curve, the coordinates' bits in turn.
    fn morton(self) -> u128 {
        let mut code = 0;
        for bit in 0..32 {
            for a in 0..3 {
                code |= u128::from(self.at[a] >> bit & 1) << (3 * bit + a as u32);
            }
        }
        code
    }
}

/// The box that is filled with blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockDomain {
    /// Shape of the blocks.
    pub shape: BlockShape,
    /// Blocks of level 0 along each axis; one along axes that are not there.
    pub roots: [u32; 3],
    /// Axes that wrap around.
    pub periodic: [bool; 3],
    /// Finest level.
    pub deepest: u8,
}

impl BlockDomain {
    /// Blocks of a level along an axis.
    pub fn blocks_along(&self, level: u8, axis: usize) -> u32 {
        if axis < self.shape.dims { self.roots[axis] << level } else { 1 }
    }

    /// The neighbour of a block by a step of at most one block along each axis, if it is inside.
    pub fn neighbour(&self, block: BlockAddress, step: [i32; 3]) -> Option<BlockAddress> {
        let mut at = block.at;
        for a in 0..3 {
            let count = i64::from(self.blocks_along(block.level, a));
            let along = i64::from(at[a]) + i64::from(step[a]);
            let inside = if self.periodic[a] { along.rem_euclid(count) } else { along };
            at[a] = u32::try_from(inside).ok().filter(|&x| i64::from(x) < count)?;
        }
        Some(BlockAddress { level: block.level, at })
    }

    /// The 27 steps to neighbours, itself included; of axes that are not there only the middle.
    pub fn steps(&self) -> impl Iterator<Item = (usize, [i32; 3])> + use<> {
        let dims = self.shape.dims;
        (0..27)
            .map(|number| (number, step(number)))
            .filter(move |(_, step)| (dims..3).all(|a| step[a] == 0))
    }

    /// Every block of a level.
    fn level(&self, level: u8) -> impl Iterator<Item = BlockAddress> + use<> {
        let [x, y, z] = [0, 1, 2].map(|a| self.blocks_along(level, a));
        (0..z).flat_map(move |z| {
            (0..y).flat_map(move |y| (0..x).map(move |x| BlockAddress { level, at: [x, y, z] }))
        })
    }
}

/// The step to a neighbour, by its number.
pub fn step(number: usize) -> [i32; 3] {
    [number % 3, number / 3 % 3, number / 9].map(|k| k as i32 - 1)
}

/// The number of the step that leads nowhere.
pub const MIDDLE: usize = 13;

/// Blocks, and how they are linked.
#[derive(Clone, Debug)]
pub struct BlockTree {
    /// The box that they fill.
    pub domain: BlockDomain,
    /// The blocks in order.
    pub blocks: Vec<BlockAddress>,
    /// Blocks of each level.
    pub levels: Vec<Range<usize>>,
    /// Neighbours of each on its level by the number of the step; [`NONE`] where there is none.
    pub neighbours: Vec<[u32; 27]>,
    /// Parent of each.
    pub parents: Vec<u32>,
    /// Children of each by their numbers; [`NONE`] for a leaf.
    pub children: Vec<[u32; 8]>,
    /// Blocks without children, ascending.
    pub leaves: Vec<u32>,
    slots: HashMap<BlockAddress, u32>,
}

impl BlockTree {
    /// The smallest tree that holds the wanted blocks, which are inside and no deeper than the
    /// domain's finest level.
    pub fn new(domain: BlockDomain, wanted: impl IntoIterator<Item = BlockAddress>) -> Self {
        let mut blocks: Vec<_> = closed(&domain, wanted).into_iter().collect();
        blocks.sort_unstable_by_key(|block| (block.level, block.morton()));
        let slots: HashMap<_, _> = (0..).zip(&blocks).map(|(slot, &block)| (block, slot)).collect();
        let slot = |block: Option<BlockAddress>| {
            block.and_then(|block| slots.get(&block).copied()).unwrap_or(NONE)
        };
        let deepest = blocks.last().map_or(0, |block| block.level);
        let levels = (0..=deepest)
            .map(|level| {
                let first = blocks.partition_point(|block| block.level < level);
                first..blocks.partition_point(|block| block.level <= level)
            })
            .collect();
        let mut neighbours = vec![[NONE; 27]; blocks.len()];
        for (found, &block) in neighbours.iter_mut().zip(&blocks) {
            for (number, step) in domain.steps() {
                found[number] = slot(domain.neighbour(block, step));
            }
        }
        let parents = blocks.iter().map(|block| slot(block.parent())).collect();
        let children: Vec<[u32; 8]> = blocks
            .iter()
            .map(|&block| {
                let mut children = [NONE; 8];
                for number in 0..domain.shape.children() {
                    children[number] = slot(Some(block.child(&domain.shape, number)));
                }
                children
            })
            .collect();
        let leaves =
            (0..).zip(&children).filter(|(_, c)| c[0] == NONE).map(|(slot, _)| slot).collect();
        Self { domain, blocks, levels, neighbours, parents, children, leaves, slots }
    }

    /// Place of a block in the order.
    pub fn slot(&self, block: BlockAddress) -> Option<usize> {
        self.slots.get(&block).map(|&slot| slot as usize)
    }
}

/// The wanted blocks, the two coarsest levels, and what a tree needs besides.
fn closed(
    domain: &BlockDomain,
    wanted: impl IntoIterator<Item = BlockAddress>,
) -> HashSet<BlockAddress> {
    let mut open: Vec<BlockAddress> = wanted.into_iter().collect();
    open.extend(domain.level(0));
    open.extend(domain.level(domain.deepest.min(1)));
    let mut found = HashSet::new();
    while let Some(block) = open.pop() {
        if !found.insert(block) {
            continue;
        }
        let Some(parent) = block.parent() else { continue };
        let siblings = (0..domain.shape.children()).map(|k| parent.child(&domain.shape, k));
        open.extend(siblings.filter(|block| !found.contains(block)));
        let around = domain.steps().filter_map(|(_, step)| domain.neighbour(parent, step));
        open.extend(around.filter(|block| !found.contains(block)));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deep_block_brings_its_ancestors_and_a_graded_tree() {
        let domain = BlockDomain {
            shape: BlockShape::new(2, 8),
            roots: [3, 2, 1],
            periodic: [true, false, false],
            deepest: 12,
        };
        let deep = BlockAddress { level: 12, at: [0, 4095, 0] };
        let tree = BlockTree::new(domain, [deep]);
        assert!(tree.slot(deep).is_some());
        assert_eq!(tree.levels[0].len(), 6);
        assert_eq!(tree.levels[1].len(), 24);
        // The leaves cover the box once.
        let covered: f64 = tree
            .leaves
            .iter()
            .map(|&leaf| 4.0_f64.powi(-i32::from(tree.blocks[leaf as usize].level)))
            .sum();
        assert_eq!(covered, 6.0);
        for (slot, &block) in tree.blocks.iter().enumerate() {
            assert_eq!(tree.neighbours[slot][MIDDLE] as usize, slot);
            let Some(parent) = block.parent() else { continue };
            assert_eq!(Some(tree.parents[slot] as usize), tree.slot(parent));
            for (_, step) in domain.steps() {
                let beside = domain.neighbour(parent, step);
                assert!(beside.is_none_or(|beside| tree.slot(beside).is_some()), "{block:?}");
            }
        }
        assert!(tree.blocks.len() < 900, "{} blocks", tree.blocks.len());
    }
}
