//! The fluid in SI units, and as a component of a run.

#[cfg(feature = "component")]
pub mod benchmark;
#[cfg(feature = "component")]
pub mod component;
pub mod lbm_fluid;
#[cfg(feature = "component")]
pub mod rank_shares;
#[cfg(feature = "component")]
pub mod signals;
