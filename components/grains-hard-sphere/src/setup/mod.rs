//! Before a run: parameters, checks, time step, bodies at the start.

pub mod check;
pub mod hard_resolution;
pub mod overlaps;
pub mod parameters;
pub mod placement;
pub mod refusals;
