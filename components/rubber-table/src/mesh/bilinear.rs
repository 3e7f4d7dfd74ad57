//! The bilinear map from the square -1 to 1 to a quadrilateral.

use crate::mesh::quadrilaterals::Point;

/// Corners of the reference square, in order.
const CORNERS: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Jacobian of the map from the reference square at its point (x, y), and the shape functions.
pub fn map(corners: &[Point; 4], x: f64, y: f64) -> ([f64; 4], [[f64; 2]; 4], [[f64; 2]; 2]) {
    let values = CORNERS.map(|[a, b]| 0.25 * (1.0 + a * x) * (1.0 + b * y));
    let slopes = CORNERS.map(|[a, b]| [0.25 * a * (1.0 + b * y), 0.25 * b * (1.0 + a * x)]);
    let mut jacobian = [[0.0; 2]; 2];
    for (slope, corner) in slopes.iter().zip(corners) {
        for i in 0..2 {
            for j in 0..2 {
                jacobian[i][j] += slope[i] * corner[j];
            }
        }
    }
    (values, slopes, jacobian)
}

/// Smallest determinant of the map from the reference square over the corners [m²]: an element may
/// take part where it is positive.
pub fn least_jacobian(corners: &[Point; 4]) -> f64 {
    let at = |corner: &[f64; 2]| {
        let (_, _, j) = map(corners, corner[0], corner[1]);
        j[0][0] * j[1][1] - j[0][1] * j[1][0]
    };
    CORNERS.iter().map(at).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadrilateral_that_is_folded_has_a_negative_jacobian() {
        assert!(least_jacobian(&[[1.0, 0.1], [1.9, -0.1], [2.1, 1.0], [0.8, 1.2]]) > 0.0);
        assert!(least_jacobian(&[[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]) < 0.0);
    }
}
