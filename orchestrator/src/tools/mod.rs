//! Work around runs: benchmarks, conformity of components, reports, validation.

pub mod bench;
pub mod conform;
pub mod report;
pub mod validation;
