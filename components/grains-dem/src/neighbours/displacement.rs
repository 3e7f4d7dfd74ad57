//! Displacement of bodies since neighbours were listed.

use serde::{Deserialize, Serialize};

/// Upper bound of the displacement of the bodies of each block since neighbours were listed [m].
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct MaxDisplacement {
    blocks: Vec<f64>,
    all: f64,
}

impl MaxDisplacement {
    /// Zero displacement of `blocks` blocks.
    pub fn none(blocks: usize) -> Self {
        Self { blocks: vec![0.0; blocks], all: 0.0 }
    }

    /// Distances of so many blocks count from here on.
    pub fn begin(&mut self, blocks: usize) {
        self.blocks.clear();
        self.blocks.resize(blocks, 0.0);
        self.all = 0.0;
    }

    /// Updates the maximum with the largest distance of each block's bodies from their reference
    /// positions.
    pub fn extend(&mut self, farthest: impl Iterator<Item = f64>) {
        for (block, far) in self.blocks.iter_mut().zip(farthest) {
            *block = block.max(far);
            self.all = self.all.max(*block);
        }
    }

    /// Gap that a body of block `b` and any other can have closed [m], with room for rounding.
    pub fn limit(&self, b: usize) -> f64 {
        (self.blocks[b] + self.all) * (1.0 + 1e-6)
    }
}
