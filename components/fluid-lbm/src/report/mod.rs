//! Before a run and beside it: checks, findings, signals, the component.

#[cfg(feature = "component")]
pub mod component;
pub mod compression;
pub mod diagnostics;
pub mod findings;
pub mod gap_findings;
pub mod gap_width_check;
pub mod grain_space_check;
pub mod part_extent;
pub mod reservoir_findings;
pub mod resolution;
pub mod scene_check;
pub mod signal_meanings;
