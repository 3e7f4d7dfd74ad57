//! Work around runs: benchmarks, comparisons, conformity of components, replays, reports, validation.

pub mod bench;
pub mod compare;
pub mod conform;
pub mod replay;
pub mod report;
pub mod validation;
