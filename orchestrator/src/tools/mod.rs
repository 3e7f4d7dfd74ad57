//! Work around runs: benchmarks, comparisons, conformity of components, replays, reports, studies,
//! validation.

pub mod bench;
pub mod compare;
pub mod conform;
pub mod replay;
pub mod report;
pub mod study;
pub mod validation;
