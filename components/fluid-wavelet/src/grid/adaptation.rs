//! Adaptation of the tree to what stands in it (Vasilyev 2003): blocks stay where wavelets are
//! significant, and one level deeper where they are large.
//!
//! A point of a level that its parent has not has a detail: half of how far its value is from the
//! parent's interpolation. It is significant where it exceeds the tolerance times the field's scale. The
//! adjacent zone is the neighbours that such a point is near to, and the children of a block with
//! large details: what moves or steepens until the next adaptation stays in it.

use crate::grid::block_shape::{BlockShape, GHOSTS};
use crate::grid::block_tree::{BlockAddress, BlockTree, MIDDLE, step};
use crate::grid::block_values::{BeyondDomain, BlockValues, FillRoom};
use crate::grid::prediction::{parent_point, predict};
use tremie_team::{Cut, Team};

/// Points from a face within which a significant point calls for the neighbour.
const ZONE: usize = 2;

/// Details of a block, over the threshold, from which on it has children. They fall by 2^4 from level
/// to level where a field is smooth: those of children are then a quarter of what is significant, and
/// have room to grow until the next adaptation.
const DEEPER: f64 = 4.0;

/// What is significant in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlockMarks {
    /// Steps to the neighbours that are called for, a bit for each; the middle is the block.
    pub wanted: u32,
    /// Number of significant points.
    pub significant: u32,
    /// True if its children are called for.
    pub deeper: bool,
}

/// Marks what is significant in each block; nothing is in level 0, which is always there. Ghosts
/// are filled. `thresholds` has the detail of each field from which on it is significant. Points
/// that `hidden` marks by other numbers than 0 are not looked at; places include ghosts.
pub fn find_marks<'a>(
    team: &mut Team,
    rooms: &mut [FillRoom],
    (tree, values): (&BlockTree, &BlockValues),
    thresholds: &[f64],
    hidden: impl Fn(usize) -> Option<&'a [u16]> + Sync,
    marks: &mut Vec<BlockMarks>,
) {
    let shape = &tree.domain.shape;
    marks.clear();
    marks.resize(tree.blocks.len(), BlockMarks::default());
    team.for_pieces_with(Cut::every(marks, 1), rooms, |room, slot, marks: &mut [BlockMarks]| {
        let block = tree.blocks[slot];
        if block.level > 0 {
            let mut is_significant = vec![false; shape.points];
            let mut deeper = false;
            let hidden = hidden(slot);
            for (field, threshold) in thresholds.iter().enumerate() {
                let parent = values.padded_field(shape, tree.parents[slot] as usize, field);
                let own = values.padded_field(shape, slot, field);
                room.for_each_detail(
                    shape,
                    block.number(),
                    parent,
                    own,
                    |number, place, detail| {
                        let is_seen = hidden.is_none_or(|hidden| hidden[place] == 0);
                        is_significant[number] |= is_seen && detail.abs() >= *threshold;
                        deeper |= is_seen && detail.abs() >= DEEPER * *threshold;
                    },
                );
            }
            marks[0] = BlockMarks { deeper, ..marks_of(shape, &is_significant) };
        }
    });
}

impl FillRoom {
    /// Calls `see` with the number, the place and the detail of each point that the parent has not.
    pub fn for_each_detail(
        &mut self,
        shape: &BlockShape,
        child: usize,
        parent: &[f64],
        own: &[f64],
        mut see: impl FnMut(usize, usize, f64),
    ) {
        let predicted = self.predict(shape, child, parent);
        let mut number = 0;
        let (from, to) = shape.own();
        for z in from[2]..to[2] {
            for y in from[1]..to[1] {
                for x in from[0]..to[0] {
                    let at = [x, y, z];
                    let is_odd = |a: usize| parent_point(shape.edge[a], 0, at[a]).1;
                    if (0..shape.dims).any(is_odd) {
                        let place = shape.place(at);
                        see(number, place, 0.5 * (own[place] - predicted[place]));
                    }
                    number += 1;
                }
            }
        }
    }

    /// A field of a block, interpolated from its parent's.
    pub fn predict(&mut self, shape: &BlockShape, child: usize, parent: &[f64]) -> &[f64] {
        let (predicted, between) = self.arrays();
        predict(shape, child, parent, predicted, between);
        predicted
    }
}

/// The neighbours that significant points call for.
fn marks_of(shape: &BlockShape, is_significant: &[bool]) -> BlockMarks {
    let mut marks = BlockMarks::default();
    for (number, _) in is_significant.iter().enumerate().filter(|(_, is)| **is) {
        let at = shape.own_at(number);
        for beside in 0..27 {
            let reaches = (0..3).all(|a| match step(beside)[a] {
                _ if a >= shape.dims => step(beside)[a] == 0,
                -1 => at[a] < ZONE,
                1 => at[a] + ZONE >= shape.edge[a],
                _ => true,
            });
            marks.wanted |= u32::from(reaches) << beside;
        }
        marks.significant += 1;
    }
    marks
}

/// The blocks that marks call for.
pub fn wanted_blocks(tree: &BlockTree, marks: &[BlockMarks]) -> Vec<BlockAddress> {
    let domain = &tree.domain;
    let mut wanted = Vec::new();
    for (&block, marks) in tree.blocks.iter().zip(marks) {
        for (number, step) in domain.steps().filter(|(number, _)| marks.wanted >> number & 1 == 1) {
            wanted.extend(domain.neighbour(block, step));
            if number == MIDDLE && marks.deeper && block.level < domain.deepest {
                wanted.push(block.child(&domain.shape, 0));
            }
        }
    }
    wanted
}

/// Carries values over to another tree, and fills their ghosts. A block that is new is interpolated
/// from its parent.
pub fn carry_over(
    team: &mut Team,
    rooms: &mut [FillRoom],
    (old_tree, old): (&BlockTree, &BlockValues),
    tree: &BlockTree,
    beyond: &impl BeyondDomain,
) -> BlockValues {
    let shape = &tree.domain.shape;
    let mut values = BlockValues::new(tree, old.fields);
    let (own_length, length) = (old.fields * shape.points, old.fields * shape.stored);
    for level in 0..tree.levels.len() {
        let range = tree.levels[level].clone();
        let BlockValues { own, padded, .. } = &mut values;
        let own = &mut own[range.start * own_length..range.end * own_length];
        let padded = &*padded;
        team.for_pieces_with(Cut::every(own, own_length), rooms, |room, k, own: &mut [f64]| {
            let slot = range.start + k;
            let block = tree.blocks[slot];
            if let Some(before) = old_tree.slot(block) {
                own.copy_from_slice(&old.own[before * own_length..][..own_length]);
                return;
            }
            let parent = tree.parents[slot] as usize * length;
            for field in 0..old.fields {
                let parent = &padded[parent + field * shape.stored..][..shape.stored];
                let predicted = room.predict(shape, block.number(), parent);
                take_own(shape, predicted, &mut own[field * shape.points..][..shape.points]);
            }
        });
        values.fill_level(team, rooms, tree, level, beyond);
    }
    values
}

/// Takes a block's own points out of a field with ghosts.
pub fn take_own(shape: &BlockShape, padded: &[f64], own: &mut [f64]) {
    let (from, to) = shape.own();
    for (row, own) in shape.rows(from, to).zip(own.chunks_exact_mut(shape.edge[0])) {
        own.copy_from_slice(&padded[row..row + shape.edge[0]]);
    }
}

/// Integral of a field over a domain that wraps around, in cells of level 0: each wavelet has that of the scaling
/// function at its point, a cell of its level.
pub fn integral(rooms: &mut FillRoom, tree: &BlockTree, values: &BlockValues, field: usize) -> f64 {
    let shape = &tree.domain.shape;
    let mut sum = 0.0;
    for (slot, &block) in tree.blocks.iter().enumerate() {
        let own = values.padded_field(shape, slot, field);
        let mut of_block = 0.0;
        if block.level == 0 {
            let (from, to) = shape.own();
            for row in shape.rows(from, to) {
                of_block += own[row..row + shape.edge[0]].iter().sum::<f64>();
            }
        } else {
            let parent = values.padded_field(shape, tree.parents[slot] as usize, field);
            rooms
                .for_each_detail(shape, block.number(), parent, own, |_, _, d| of_block += 2.0 * d);
        }
        sum += of_block * 0.5_f64.powi(i32::from(block.level) * shape.dims as i32);
    }
    sum
}

const _: () = assert!(ZONE <= GHOSTS);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::block_tree::BlockDomain;

    /// Nothing lies beyond.
    struct Periodic;

    impl BeyondDomain for Periodic {
        fn fill(&self, _: &BlockTree, _: BlockAddress, _: &mut [f64]) {}
    }

    /// The complete tree of a line of 1024 points, with a front and a bump (periodic: the front is
    /// mirrored).
    fn line() -> (BlockTree, BlockValues) {
        let domain = BlockDomain {
            shape: BlockShape::new(1, 16),
            roots: [2, 1, 1],
            periodic: [true, false, false],
            deepest: 6,
        };
        let wanted = (0..128).map(|x| BlockAddress { level: 6, at: [x, 0, 0] });
        let tree = BlockTree::new(domain, wanted);
        let mut values = BlockValues::new(&tree, 1);
        for (slot, block) in tree.blocks.iter().enumerate() {
            for k in 0..16 {
                let spacing = 4.0 / (32.0 * f64::from(1 << block.level));
                let x = (f64::from(block.at[0]) * 16.0 + k as f64) * spacing - 1.0;
                values.own[slot * 16 + k] = profile(x);
            }
        }
        (tree, values)
    }

    fn profile(x: f64) -> f64 {
        let x = if x > 1.0 { 2.0 - x } else { x };
        -((x + 0.3) / 0.02).tanh() + (-64.0 * (x - 0.4) * (x - 0.4)).exp()
    }

    #[test]
    fn the_error_follows_the_tolerance_and_points_its_fourth_root() {
        let mut team = Team::new("test", 2).expect("threads");
        let (tree, values) = line();
        let shape = tree.domain.shape;
        let mut rooms = [FillRoom::new(&shape), FillRoom::new(&shape)];
        let mut full = values.clone();
        full.restrict(&mut team, &tree);
        full.fill(&mut team, &mut rooms, &tree, &Periodic);
        let mut marks = Vec::new();
        // Of both halves, each of which holds the profile once.
        let mut counts = Vec::new();
        for eps in [1e-2, 1e-3, 1e-4, 1e-5] {
            find_marks(&mut team, &mut rooms, (&tree, &full), &[eps], |_| None, &mut marks);
            let kept: u32 = marks.iter().map(|marks| marks.significant).sum();
            counts.push(f64::from(kept + 32) / 2.0);
            let small = BlockTree::new(tree.domain, wanted_blocks(&tree, &marks));
            let coarse = carry_over(&mut team, &mut rooms, (&tree, &full), &small, &Periodic);
            let whole = carry_over(&mut team, &mut rooms, (&small, &coarse), &tree, &Periodic);
            let error = whole.own.iter().zip(&full.own).map(|(a, b)| (a - b).abs());
            let error = error.fold(0.0, f64::max);
            assert!(error <= 3.0 * eps, "eps {eps}: error {error}");
        }
        // `-tanh((x + 0.3)/0.02) + exp(-64 (x - 0.4)^2)` on 1025 points: 31, 49, 84 and 139 points
        // of lifted wavelets, 17 of them on the coarsest level.
        for (count, wanted) in counts.iter().zip([31.0, 49.0, 84.0, 139.0]) {
            assert!((count / wanted - 1.0).abs() < 0.1, "{counts:?}");
        }
    }

    #[test]
    fn wavelets_integrate_to_what_all_points_do() {
        let mut team = Team::new("test", 1).expect("threads");
        let (tree, mut values) = line();
        let shape = tree.domain.shape;
        let mut rooms = [FillRoom::new(&shape)];
        values.restrict(&mut team, &tree);
        values.fill(&mut team, &mut rooms, &tree, &Periodic);
        let range = tree.levels[6].clone();
        let all: f64 = values.own[range.start * 16..range.end * 16].iter().sum();
        let found = integral(&mut rooms[0], &tree, &values, 0);
        assert!((found - all / 64.0).abs() < 1e-11 * all.abs(), "{found} {}", all / 64.0);
    }
}
