//! The hard spheres of a scene, and as a component of a run.

#[cfg(feature = "component")]
pub mod benchmark;
#[cfg(feature = "component")]
pub mod component;
pub mod findings;
pub mod hard_spheres;
#[cfg(feature = "component")]
pub mod signals;
