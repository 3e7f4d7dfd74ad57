//! The user's settings.

pub mod parameters;
