//! Values at the points of a tree of blocks.
//!
//! Blocks with children have values as well: those of the points that they share with these. So a
//! block's parent is whole, and what a block lacks beyond its own points is its neighbour's on the
//! same level, or interpolated from its parent.

use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockTree, NONE, step};
use crate::grid::short_copy::copy_row;
use tremie_team::{Cut, Team};

/// Fields at the points of a tree's blocks. A block's fields lie one after the other.
#[derive(Clone, Debug)]
pub struct BlockValues {
    /// Number of fields.
    pub fields: usize,
    /// At the blocks' own points.
    pub own: Vec<f64>,
    /// The same with ghosts.
    pub padded: Vec<f64>,
}

/// Room for a thread to interpolate in.
pub struct FillRoom {
    predicted: Vec<f64>,
    between: Vec<f64>,
}

impl FillRoom {
    /// For blocks of a shape.
    pub fn new(shape: &BlockShape) -> Self {
        Self { predicted: vec![0.0; shape.stored], between: vec![0.0; shape.stored] }
    }

    /// Arrays as long as a field with its ghosts.
    pub(crate) fn arrays(&mut self) -> (&mut [f64], &mut [f64]) {
        (&mut self.predicted, &mut self.between)
    }
}

/// Gives the ghosts beyond the domain their values, once all others are filled, and the points on
/// its faces.
pub trait BeyondDomain: Sync {
    /// Of a block's fields, ghosts included.
    fn fill(&self, tree: &BlockTree, block: BlockAddress, padded: &mut [f64]);
}

impl BlockValues {
    /// Zero everywhere.
    pub fn new(tree: &BlockTree, fields: usize) -> Self {
        let shape = &tree.domain.shape;
        let blocks = fields * tree.blocks.len();
        Self {
            fields,
            own: vec![0.0; blocks * shape.points],
            padded: vec![0.0; blocks * shape.stored],
        }
    }

    /// Gives blocks with children the values that they share with these.
    pub fn restrict(&mut self, team: &mut Team, tree: &BlockTree) {
        let (shape, fields) = (&tree.domain.shape, self.fields);
        let length = fields * shape.points;
        for range in tree.levels.iter().rev().skip(1) {
            let (coarse, fine) = self.own.split_at_mut(range.end * length);
            let fine = &*fine;
            let pieces = Cut::every(&mut coarse[range.start * length..], length);
            team.for_pieces(pieces, |k, own: &mut [f64]| {
                let children = tree.children[range.start + k];
                if children[0] == NONE {
                    return;
                }
                for number in 0..shape.children() {
                    let child = (children[number] as usize - range.end) * length;
                    for field in 0..fields {
                        let from = &fine[child + field * shape.points..][..shape.points];
                        share(
                            shape,
                            number,
                            from,
                            &mut own[field * shape.points..][..shape.points],
                        );
                    }
                }
            });
        }
    }

    /// Fills the ghosts of all blocks.
    pub fn fill(
        &mut self,
        team: &mut Team,
        rooms: &mut [FillRoom],
        tree: &BlockTree,
        beyond: &impl BeyondDomain,
    ) {
        for level in 0..tree.levels.len() {
            self.fill_level(team, rooms, tree, level, beyond);
        }
    }

    /// Fills the ghosts of the blocks of a level, once those of coarser levels are filled.
    pub fn fill_level(
        &mut self,
        team: &mut Team,
        rooms: &mut [FillRoom],
        tree: &BlockTree,
        level: usize,
        beyond: &impl BeyondDomain,
    ) {
        let (shape, fields, own) = (&tree.domain.shape, self.fields, &self.own);
        let length = fields * shape.stored;
        let range = tree.levels[level].clone();
        let (coarser, rest) = self.padded.split_at_mut(range.start * length);
        let pieces = Cut::every(&mut rest[..range.len() * length], length);
        team.for_pieces_with(pieces, rooms, |room, k, padded: &mut [f64]| {
            let slot = range.start + k;
            for field in 0..fields {
                let out = &mut padded[field * shape.stored..][..shape.stored];
                let of = |slot: u32| {
                    let first = (slot as usize * fields + field) * shape.points;
                    &own[first..first + shape.points]
                };
                let parent = || {
                    let first = tree.parents[slot] as usize * length + field * shape.stored;
                    &coarser[first..first + shape.stored]
                };
                fill_field(tree, slot, of, parent, room, out);
            }
            beyond.fill(tree, tree.blocks[slot], padded);
        });
    }

    /// A field of a block, ghosts included.
    pub fn padded_field(&self, shape: &BlockShape, slot: usize, field: usize) -> &[f64] {
        &self.padded[(slot * self.fields + field) * shape.stored..][..shape.stored]
    }
}

/// Gives a parent what it shares with a child.
fn share(shape: &BlockShape, child: usize, from: &[f64], to: &mut [f64]) {
    let (edge, half) = (shape.edge, shape.half(child));
    let shared = |a: usize| if a < shape.dims { edge[a] / 2 } else { 1 };
    let place = |at: [usize; 3]| at[0] + edge[0] * (at[1] + edge[1] * at[2]);
    for z in 0..shared(2) {
        for y in 0..shared(1) {
            let source = place([0, 2 * y, 2 * z]);
            let corner = [0, 1, 2].map(|a| half[a] * shared(a));
            let target = place([corner[0], corner[1] + y, corner[2] + z]);
            for x in 0..shared(0) {
                to[target + x] = from[source + 2 * x];
            }
        }
    }
}

/// Fills a field of a block: its own points, those of neighbours, and the others from its parent.
fn fill_field<'a>(
    tree: &BlockTree,
    slot: usize,
    of: impl Fn(u32) -> &'a [f64],
    parent: impl Fn() -> &'a [f64],
    room: &mut FillRoom,
    out: &mut [f64],
) {
    let (domain, block) = (&tree.domain, tree.blocks[slot]);
    let shape = &domain.shape;
    let mut is_predicted = false;
    for (number, _) in domain.steps() {
        let beside = tree.neighbours[slot][number];
        let (from, to, source) = shared_region(shape, step(number));
        if beside != NONE {
            copy_region(shape, of(beside), source, out, (from, to));
        } else if domain.neighbour(block, step(number)).is_some() {
            if !is_predicted {
                room.predict(shape, block.number(), parent());
                is_predicted = true;
            }
            for row in shape.rows(from, to) {
                let row = row..row + to[0] - from[0];
                copy_row(&room.predicted[row.clone()], &mut out[row]);
            }
        }
    }
}

/// The ghosts that lie in the neighbour at a step, counted from the first ghost, and the first of
/// these points in the neighbour.
fn shared_region(shape: &BlockShape, step: [i32; 3]) -> ([usize; 3], [usize; 3], [usize; 3]) {
    let (mut from, mut to, mut source) = ([0; 3], [0; 3], [0; 3]);
    for a in 0..3 {
        let (edge, ghosts) = (shape.edge[a], shape.ghosts[a]);
        (from[a], to[a], source[a]) = match step[a] {
            -1 => (0, ghosts, edge - ghosts),
            0 => (ghosts, ghosts + edge, 0),
            _ => (ghosts + edge, 2 * ghosts + edge, 0),
        };
    }
    (from, to, source)
}

/// Copies the points of a neighbour to where they are ghosts.
fn copy_region(
    shape: &BlockShape,
    beside: &[f64],
    source: [usize; 3],
    out: &mut [f64],
    (from, to): ([usize; 3], [usize; 3]),
) {
    let run = to[0] - from[0];
    for z in 0..to[2] - from[2] {
        for y in 0..to[1] - from[1] {
            let own = source[0] + shape.edge[0] * (source[1] + y + shape.edge[1] * (source[2] + z));
            let row = shape.place([from[0], from[1] + y, from[2] + z]);
            copy_row(&beside[own..own + run], &mut out[row..row + run]);
        }
    }
}
