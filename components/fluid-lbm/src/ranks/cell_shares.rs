//! Which cells of a lattice each rank computes.
//!
//! Stored cells have numbers in the order of the box, and each 4096 of them are a block. A rank has blocks that
//! follow each other, as many as any other but for one. It also holds copies of the cells around them, whole blocks
//! again, some layers deep ([`depth`]) along the lattice's last axis: a step computes these, too, and then takes what their
//! own rank says. So everything that looks at neighbours finds them, and finds what a lattice in one piece has there.
//!
//! A rank's cells keep their places within lines and blocks: what is added up in a block has the same bits whoever
//! computes it.

use crate::lattice::held_blocks::HeldBlocks;
use crate::lattice::layout::CELLS_PER_BLOCK;
use std::ops::Range;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_fluid_kit::cells::obstacles::Obstacles;
use tremie_messages::scene::{BodySet, Face, Motion, Part, Placement, Scene};

/// Layers of copies around a rank's cells: so far a step looks. What streams comes from the next cell. A cell that a
/// body uncovers takes from its neighbours before that; and an edge that cuts a link between two cells looks behind
/// either.
pub fn depth(scene: &Scene, obstacles: &Obstacles) -> i32 {
    // Surfaces that deform move, too; a gap opens and shuts between parts that do.
    let moves = |part: &Part| !matches!(part.motion, Motion::Fixed);
    let is_polyhedra = |set: &BodySet| matches!(set.placement, Placement::Polyhedra(_));
    let deforms = !scene.surfaces.is_empty();
    if deforms || scene.parts.iter().any(moves) || scene.bodies.iter().any(is_polyhedra) {
        return 3;
    }
    let is_open =
        |face: &Face| !matches!(face, Face::Periodic | Face::Wall { .. } | Face::Symmetry);
    let opens = scene.domain.faces.iter().flatten().any(is_open);
    let looks_on = opens || !scene.bodies.is_empty() || !obstacles.sheets.is_empty();
    if looks_on { 2 } else { 1 }
}

/// The blocks of a lattice, shared out among ranks.
#[derive(Clone, Debug)]
pub struct CellShares {
    /// First and last layer of each block.
    layers: Vec<[i32; 2]>,
    /// Layers of the box, and whether the last is next to the first.
    count: i32,
    is_periodic: bool,
    ranks: usize,
    depth: i32,
    /// Cells that are stored in all.
    cells: usize,
}

impl CellShares {
    /// Of a box with static solids, for so many ranks, with copies so many layers deep; see [`depth`].
    ///
    /// # Errors
    /// More ranks than blocks: a sentence.
    pub fn new(
        grid: &Grid,
        obstacles: &Obstacles,
        (ranks, depth): (usize, i32),
    ) -> Result<Self, String> {
        let layer_cells = (grid.n[0] * grid.n[1]) as usize;
        let (mut layers, mut stored): (Vec<[i32; 2]>, u32) = (Vec::new(), 0);
        for index in 0..grid.len() {
            if obstacles.solid.get(index).is_some_and(|&solid| solid != 0) {
                continue;
            }
            let layer = (index / layer_cells) as i32;
            match layers.last_mut() {
                Some(last) if stored % CELLS_PER_BLOCK != 0 => last[1] = layer,
                _ => layers.push([layer; 2]),
            }
            stored += 1;
        }
        if layers.len() < ranks {
            return Err(format!(
                "{stored} cells are {0} blocks of {CELLS_PER_BLOCK}, too few for {ranks} ranks; take at most {0}",
                layers.len()
            ));
        }
        let (count, is_periodic, cells) = (grid.n[2], grid.periodic[2], stored as usize);
        Ok(Self { layers, count, is_periodic, ranks, depth, cells })
    }

    /// The blocks that a rank counts.
    pub fn own(&self, rank: usize) -> Range<u32> {
        let begin = |rank: usize| (self.layers.len() * rank / self.ranks) as u32;
        begin(rank)..begin(rank + 1)
    }

    /// The layer in which the cells of a rank begin; that behind the last one for one rank more than there are.
    pub fn first_layer(&self, rank: usize) -> i32 {
        let first = self.own(rank).start;
        self.layers.get(first as usize).map_or(self.count, |layers| layers[0])
    }

    /// All that a rank holds.
    pub fn window(&self, rank: usize) -> HeldBlocks {
        let own = self.own(rank);
        let all = &self.layers[own.start as usize..own.end as usize];
        let first = all.first().map_or(0, |layers| layers[0]) - self.depth;
        let last = all.last().map_or(0, |layers| layers[1]) + self.depth;
        let meets = |[low, high]: [i32; 2]| {
            let shifts = if self.is_periodic { -1..=1 } else { 0..=0 };
            let shifts = shifts.map(|turns: i32| turns * self.count);
            shifts.into_iter().any(|shift| low + shift <= last && high + shift >= first)
        };
        let held = (0..).zip(&self.layers).filter(|(_, layers)| meets(**layers));
        HeldBlocks::new(held.map(|(block, _)| block).collect(), own, self.cells)
    }

    /// The blocks that a rank holds copies of, and another counts.
    pub fn copies(&self, holder: usize, owner: usize) -> impl Iterator<Item = u32> {
        let (window, own) = (self.window(holder), self.own(owner));
        window.into_blocks().filter(move |block| own.contains(block))
    }

    /// Layers of copies.
    pub fn depth(&self) -> i32 {
        self.depth
    }

    /// Number of ranks.
    pub fn ranks(&self) -> usize {
        self.ranks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every block is one rank's own; a window holds all cells in reach of its own, through a periodic face too.
    #[test]
    fn windows_hold_what_is_in_reach() {
        let grid = Grid::walled([40, 30, 90], [false, false, true]);
        let shares = CellShares::new(&grid, &Obstacles::default(), (5, 3)).unwrap();
        let all: Vec<u32> = (0..5).flat_map(|rank| shares.own(rank)).collect();
        assert!(all.iter().copied().eq(0..(40_u32 * 30 * 90).div_ceil(CELLS_PER_BLOCK)));
        for rank in 0..5 {
            let (window, own) = (shares.window(rank), shares.own(rank));
            let held = (0..40 * 30 * 90).filter(|&cell| window.holds(cell)).count();
            let cells = window.own_cells(held);
            assert_eq!(cells.start % CELLS_PER_BLOCK, 0);
            for block in own {
                let first = block * CELLS_PER_BLOCK;
                for step in [-3 * 1200, 3 * 1200] {
                    let near = (first as i32 + step).rem_euclid(40 * 30 * 90) as u32;
                    assert!(window.holds(near), "{rank} {first} {step}");
                }
            }
        }
        assert!(
            CellShares::new(&grid, &Obstacles::default(), (500, 3))
                .unwrap_err()
                .contains("too few")
        );
    }
}
