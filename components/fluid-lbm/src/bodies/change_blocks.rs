//! Bricks of cells, and the step in which a cell of each last joined the fluid or left it.
//!
//! Lists made from the fluid cells around a body hold until a cell changes in one of the bricks
//! there. To see that takes a few numbers to compare instead of rows of bits to read.

use crate::lattice::layout::Layout;
use tremie_fluid_kit::cells::grid::Grid;

/// Cells along an edge of a brick: 2 to this power.
const EDGE_BITS: u32 = 3;

/// The bricks of a box.
#[derive(Clone, Debug, Default)]
pub struct ChangeBlocks {
    /// Number along each axis.
    count: [usize; 3],
    /// For each brick, x running fastest, the step in which a cell changed last.
    changed: Vec<u64>,
    /// Number of this step.
    step: u64,
}

impl ChangeBlocks {
    /// Those of a box.
    pub fn new(grid: &Grid) -> Self {
        let count = grid.n.map(|n| (n as usize >> EDGE_BITS) + 1);
        Self { count, changed: vec![0; count.iter().product()], step: 0 }
    }

    /// Begins a step in which these cells change.
    pub fn begin(&mut self, layout: &Layout, cells: impl Iterator<Item = u32>) {
        self.step += 1;
        for cell in cells {
            let brick = self.number(layout.at(cell).map(|k| k as usize >> EDGE_BITS));
            self.changed[brick] = self.step;
        }
    }

    /// Number of this step.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// True if no cell of some bricks has changed since the end of a step.
    #[inline(always)]
    pub fn are_as_in(&self, bricks: &[u32], step: u64) -> bool {
        bricks.iter().all(|&brick| self.changed[brick as usize] <= step)
    }

    /// Lists the bricks of the cells from `first` to `last`, which may lie beyond faces.
    pub fn list(&self, grid: &Grid, first: [i32; 3], last: [i32; 3], list: &mut Vec<u32>) {
        list.clear();
        let along = |a: usize| {
            let mut before = usize::MAX;
            let within = move |k: i32| {
                let k = grid.wrap(a, k);
                (0..grid.n[a]).contains(&k).then_some(k as usize >> EDGE_BITS)
            };
            let is_next = move |brick: &usize| std::mem::replace(&mut before, *brick) != *brick;
            (first[a]..=last[a]).filter_map(within).filter(is_next)
        };
        for z in along(2) {
            for y in along(1) {
                list.extend(along(0).map(|x| self.number([x, y, z]) as u32));
            }
        }
    }

    /// Largest number of bricks that a cube of `side` cells can lie in.
    pub fn most(side: i32) -> usize {
        // One more along an axis where it does not begin at a face of bricks, another through a
        // face of the box.
        ((side >> EDGE_BITS) as usize + 3).pow(3)
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.count[1] + y) * self.count[0] + x
    }

    /// Memory that they take [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.changed.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bricks_of_cells_through_a_face_are_told_of_changes() {
        let layout = Layout::open(Grid::walled([20, 10, 8], [true; 3]));
        let mut bricks = ChangeBlocks::new(&layout.grid);
        let mut list = Vec::new();
        // From x = 15 through the face to 3: the last brick, half as long, lies between.
        bricks.list(&layout.grid, [15, 2, -1], [23, 5, 3], &mut list);
        assert_eq!(list, [1, 2, 0]);
        let cell = |at| layout.cell(at).unwrap();
        for (step, (at, is_there)) in (0..).zip([
            ([17, 3, 3], true),
            ([2, 7, 7], true),
            ([3, 8, 0], false),
            ([8, 0, 0], true),
        ]) {
            bricks.begin(&layout, [cell(at)].into_iter());
            assert_eq!(bricks.are_as_in(&list, step), !is_there, "{at:?}");
            assert!(bricks.are_as_in(&list, step + 1));
        }
    }
}
