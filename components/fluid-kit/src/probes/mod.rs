//! Places where a run measures the fluid.

pub mod probe_plan;
pub mod probe_signals;
pub mod sampling;
