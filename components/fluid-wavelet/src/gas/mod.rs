//! The gas: its law, and what its motion changes at the points of a block.

pub mod block_rates;
mod central_flux;
pub mod gas_law;
mod shock_flux;
pub(crate) mod viscous_flux;
