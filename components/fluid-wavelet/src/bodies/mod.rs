//! Rigid bodies in the gas: where they are, what stands in them, and what loads they take.

pub mod body_mask;
pub mod gas_body;
pub mod inside_points;
pub mod momentum_loads;
pub mod surface_loads;
