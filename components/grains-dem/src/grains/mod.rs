//! The grains as a component of a run: findings, signals, messages.

#[cfg(feature = "component")]
pub mod benchmark;
#[cfg(feature = "component")]
pub mod component;
pub mod findings;
#[cfg(feature = "component")]
pub mod followed;
pub mod from_scene;
#[cfg(feature = "component")]
pub mod signals;
#[cfg(feature = "component")]
pub mod surface_messages;
