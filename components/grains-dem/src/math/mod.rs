//! Numbers: vectors of several lanes, the periodic box, random numbers, errors.

pub mod damping;
pub mod debris;
pub mod error;
pub mod parameters;
pub mod simd;
pub mod tally;
