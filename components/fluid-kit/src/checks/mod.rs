//! Before a run: what of a scene is too small for its cells.

pub mod cell_findings;
pub mod gap_width_check;
pub mod grain_space_check;
pub mod material_check;
pub mod mended_part;
pub mod no_threads;
pub mod part_extent;
pub mod smallest_body;
