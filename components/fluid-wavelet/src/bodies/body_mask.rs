//! Which points of the blocks are inside bodies, and which blocks must be fine for it.

use crate::bodies::gas_body::GasBody;
use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockDomain, BlockTree, spacing_of_level};

/// Points on either side of a surface that are of the finest level.
pub const BAND: f64 = 6.0;

/// Points beyond a block's farthest ghost at which a body still counts as near: the stress on its
/// surface is taken up to four and a half points away.
pub const BEYOND_GHOSTS: f64 = 1.5;

/// Where blocks stand.
#[derive(Clone, Copy, Debug)]
pub struct BlockPlaces {
    /// Shape of the blocks.
    pub shape: BlockShape,
    /// Lower corner of the domain [m].
    pub origin: [f64; 3],
    /// Spacing of level 0 [m].
    pub coarsest: f64,
}

impl BlockPlaces {
    /// Spacing of a level [m].
    pub fn spacing(&self, level: u8) -> f64 {
        spacing_of_level(self.coarsest, level)
    }

    /// Place of a point of a block, counted from its first ghost [m].
    pub fn padded_point(&self, block: BlockAddress, at: [usize; 3]) -> [f64; 3] {
        let spacing = self.spacing(block.level);
        std::array::from_fn(|a| {
            let first = i64::from(block.at[a]) * self.shape.edge[a] as i64;
            let along = first + at[a] as i64 - self.shape.ghosts[a] as i64;
            if a < self.shape.dims { self.origin[a] + spacing * along as f64 } else { 0.0 }
        })
    }

    /// Centre of a block, and the distance of its farthest ghost [m].
    fn ball_around(&self, block: BlockAddress) -> ([f64; 3], f64) {
        let (shape, spacing) = (&self.shape, self.spacing(block.level));
        let low = self.padded_point(block, [0; 3]);
        let half = [0, 1, 2].map(|a| 0.5 * spacing * (shape.padded[a] - 1) as f64);
        let reach = half.iter().map(|x| x * x).sum::<f64>().sqrt();
        (std::array::from_fn(|a| low[a] + half[a]), reach)
    }
}

/// The points of blocks that are inside bodies.
#[derive(Clone, Debug, Default)]
pub struct BodyMask {
    /// Where in the marks a block's stand, for blocks that have some.
    first: Vec<Option<u32>>,
    /// For each point, ghosts included, 0 in gas, and the body's number and one inside it.
    marks: Vec<u16>,
    /// For each block, where the numbers of the bodies near it begin and end.
    near: Vec<[u32; 2]>,
    /// These numbers, ascending for each block.
    numbers: Vec<u16>,
}

impl BodyMask {
    /// Finds the points inside bodies.
    pub fn find(&mut self, tree: &BlockTree, places: &BlockPlaces, bodies: &[impl GasBody]) {
        let shape = &places.shape;
        self.first.clear();
        self.first.resize(tree.blocks.len(), None);
        self.marks.clear();
        self.near.clear();
        self.numbers.clear();
        for (slot, &block) in tree.blocks.iter().enumerate() {
            let (centre, reach) = places.ball_around(block);
            let reach = reach + BEYOND_GHOSTS * places.spacing(block.level);
            let begin = self.numbers.len() as u32;
            for (number, body) in bodies.iter().enumerate() {
                if body.height(centre).0 >= reach {
                    continue;
                }
                self.numbers.push(number as u16);
                let marks = &mut self.marks;
                let first = *self.first[slot].get_or_insert_with(|| {
                    let first = marks.len();
                    marks.resize(first + shape.stored, 0);
                    first as u32
                }) as usize;
                for place in 0..shape.stored {
                    let at = places.padded_point(block, shape.at(place));
                    if self.marks[first + place] == 0 && body.height(at).0 < 0.0 {
                        self.marks[first + place] = number as u16 + 1;
                    }
                }
            }
            self.near.push([begin, self.numbers.len() as u32]);
        }
    }

    /// Numbers of the bodies that come near a block, ascending.
    pub fn near(&self, slot: usize) -> &[u16] {
        let [begin, end] = self.near.get(slot).copied().unwrap_or_default();
        &self.numbers[begin as usize..end as usize]
    }

    /// Marks of a block's points, ghosts included, if bodies come near it.
    pub fn of(&self, shape: &BlockShape, slot: usize) -> Option<&[u16]> {
        let first = (*self.first.get(slot)?)? as usize;
        Some(&self.marks[first..first + shape.stored])
    }
}

/// The blocks of the finest level near surfaces.
pub fn blocks_at_surfaces(
    domain: &BlockDomain,
    places: &BlockPlaces,
    bodies: &[impl GasBody],
) -> Vec<BlockAddress> {
    let finest = places.spacing(domain.deepest);
    let mut open: Vec<_> = BlockTree::new(*domain, []).blocks;
    open.retain(|block| block.level == 0);
    let mut found = Vec::new();
    while let Some(block) = open.pop() {
        let (centre, reach) = places.ball_around(block);
        if bodies.iter().any(|body| body.height(centre).0.abs() < reach + BAND * finest) {
            if block.level == domain.deepest {
                found.push(block);
            } else {
                open.extend((0..domain.shape.children()).map(|k| block.child(&domain.shape, k)));
            }
        }
    }
    found
}
