//! What a user chooses, and what a scene says of the gas.

pub mod initial_gas;
pub mod parameters;
pub mod world_axes;
