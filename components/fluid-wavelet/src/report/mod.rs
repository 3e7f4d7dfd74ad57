//! Before a run: what parameters and scene come to, what is wrong with them, and findings.

pub mod findings;
pub mod resolution;
pub mod scene_check;
