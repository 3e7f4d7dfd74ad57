//! The gas as its users see it, and as a component of a run.

#[cfg(feature = "component")]
pub mod benchmark;
#[cfg(feature = "component")]
pub mod component;
pub mod error;
pub mod gas_fluid;
pub mod gas_probes;
pub mod scene_bodies;
pub mod scene_faces;
#[cfg(feature = "component")]
pub mod signals;
