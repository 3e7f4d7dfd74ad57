//! The free surface.

pub mod fill_level;
