//! Checks of the numbers that a user gives.

/// True for a finite number above zero.
pub fn is_positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}
