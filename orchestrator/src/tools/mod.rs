//! Work around runs: benchmarks, comparisons, conformity of components, new scenes, replays, reports,
//! studies, jobs of Slurm, validation.

pub mod bench;
pub mod compare;
pub mod conform;
pub mod last_lines;
pub mod new_scene;
pub mod replay;
pub mod report;
pub mod shell;
pub mod slurm;
pub mod study;
pub mod validation;
