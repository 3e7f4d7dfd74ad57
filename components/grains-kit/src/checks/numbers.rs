//! Words and small checks that other checks use.

use tremie_messages::Problem;

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// True if all components are finite.
pub fn all_finite(v: &[f64; 3]) -> bool {
    v.iter().all(|x| x.is_finite())
}

/// The problem of a number that must be positive.
pub fn not_positive(key: String, value: f64) -> Problem {
    Problem::new(key, format!("is {value}, expected a positive number"))
}
