//! The fluid as its users see it, and as a component of a run.

#[cfg(feature = "component")]
pub mod benchmark;
#[cfg(feature = "component")]
pub mod component;
pub mod contact_prediction;
pub mod error;
pub mod pic_fluid;
pub mod scene_faces;
pub mod scene_solids;
#[cfg(feature = "component")]
pub mod signals;
