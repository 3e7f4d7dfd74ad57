//! Work around runs: benchmarks, comparisons, conformity of components, new scenes, replays, reports,
//! studies, validation.

pub mod bench;
pub mod compare;
pub mod conform;
pub mod new_scene;
pub mod replay;
pub mod report;
pub mod study;
pub mod validation;
