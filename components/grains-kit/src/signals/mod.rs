//! Signals that grains of every kind have.

pub mod body_signals;
pub mod followed;
pub mod shared_signals;
pub mod soundness;
