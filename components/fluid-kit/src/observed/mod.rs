//! What observers see of a fluid: a cut, and the volume.

pub mod cut;
pub mod observed_cells;
pub mod volume;
