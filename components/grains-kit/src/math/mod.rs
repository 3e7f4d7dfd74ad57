//! Numbers: random ones, checks.

pub mod numbers;
pub mod random;
