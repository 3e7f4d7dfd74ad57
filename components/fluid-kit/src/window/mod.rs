//! Values of a window: signals, loads.

pub mod fluid_signals;
pub mod part_loads;
pub mod signal_row;
pub mod substep_means;
