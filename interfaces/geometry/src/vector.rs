//! Unit vectors.

use crate::Vec3;

/// `a` at length one; `None` where it has none, or one too small or large to be squared. Unlike
/// nalgebra's `try_normalize` it multiplies by the inverse: one division.
pub fn unit(a: Vec3) -> Option<Vec3> {
    let length = a.norm();
    (length > 0.0 && length.is_finite()).then(|| a * (1.0 / length))
}
