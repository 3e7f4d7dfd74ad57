//! What numbers of a user may be.

pub(crate) fn is_positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}
