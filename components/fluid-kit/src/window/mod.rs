//! Values of a window: signals, loads.

pub mod fluid_signals;
pub mod part_loads;
pub mod substep_means;
