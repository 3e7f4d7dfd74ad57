//! The grid and its values, kept and put back.

use crate::grid::block_tree::{BlockAddress, BlockTree};
use crate::grid::block_values::BlockValues;
use crate::solver::wavelet_solver::WaveletSolver;
use tremie_state::{StateError, StateExchange};

impl WaveletSolver {
    /// Keeps blocks, values and counts, or puts them back; then [`WaveletSolver::resume`] is due.
    ///
    /// # Errors
    /// A state of another grid.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let row =
            |block: &BlockAddress| [u32::from(block.level), block.at[0], block.at[1], block.at[2]];
        let mut blocks: Vec<[u32; 4]> = self.tree.blocks.iter().map(row).collect();
        state.list("blocks", &mut blocks)?;
        if state.restores() {
            self.tree = match self.tree_of(&blocks) {
                Some(tree) => tree,
                None => return state.unfit("the blocks of the state are not those of this grid"),
            };
            self.values = BlockValues::new(&self.tree, self.values.fields);
        }
        state.array("values", &mut self.values.own)?;
        state.value("time", &mut self.time)?;
        state.value("steps", &mut self.steps)?;
        state.value("significant", &mut self.significant)?;
        state.value("loads", &mut self.loads)
    }

    /// The tree of the blocks, if it has these and no others, in this order.
    fn tree_of(&self, blocks: &[[u32; 4]]) -> Option<BlockTree> {
        let domain = self.tree.domain;
        let is_inside = |&[level, x, y, z]: &[u32; 4]| {
            u8::try_from(level).is_ok_and(|level| {
                let along = |a: usize| domain.blocks_along(level, a);
                level <= domain.deepest
                    && [x, y, z].iter().enumerate().all(|(a, at)| *at < along(a))
            })
        };
        if !blocks.iter().all(is_inside) {
            return None;
        }
        let wanted: Vec<BlockAddress> = blocks
            .iter()
            .map(|&[level, x, y, z]| BlockAddress { level: level as u8, at: [x, y, z] })
            .collect();
        let tree = BlockTree::new(domain, wanted.iter().copied());
        (tree.blocks == wanted).then_some(tree)
    }
}
