//! Signs of determinants, exact: Shewchuk's adaptive predicates, *Discrete Comput. Geom.* 18 (1997)
//! 305.
//!
//! Exact as long as no product of three coordinate differences under- or overflows: parts between
//! micrometres and megametres are far from both.

use crate::Vec3;
use robust::{Coord, Coord3D};

/// Corners of a triangle.
pub type Corners = [Vec3; 3];

/// Six times the signed volume of the tetrahedron `a b c d`: positive where `d` is on the inner
/// side of the triangle, that from which its corners appear clockwise. The sign is exact, the value
/// rounded.
pub fn below(triangle: &Corners, d: Vec3) -> f64 {
    let [a, b, c] = triangle.map(coordinates);
    robust::orient3d(a, b, c, coordinates(d))
}

#[inline]
fn coordinates(point: Vec3) -> Coord3D<f64> {
    Coord3D { x: point.x, y: point.y, z: point.z }
}

/// Twice the signed area of `a b c` seen against the axis `axis`, its first following axis to the
/// right and its second upwards. The sign is exact.
#[inline]
pub fn turn(axis: usize, a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let seen = |p: Vec3| Coord { x: p[u], y: p[v] };
    robust::orient2d(seen(a), seen(b), seen(c))
}

/// The three values of [`turn`] of a point against the edges of a triangle.
#[inline]
pub fn turns(axis: usize, [a, b, c]: &Corners, point: Vec3) -> [f64; 3] {
    [turn(axis, *a, *b, point), turn(axis, *b, *c, point), turn(axis, *c, *a, point)]
}

/// True if the numbers are all at least zero, or all at most zero.
#[inline]
pub fn agree(values: [f64; 3]) -> bool {
    values.iter().all(|&x| x >= 0.0) || values.iter().all(|&x| x <= 0.0)
}

/// True if a point is on a triangle, its edges and corners included. A triangle without area has
/// no point: those of its longest edge belong to the neighbour there.
pub fn on_triangle(triangle: &Corners, point: Vec3) -> bool {
    let [a, b, c] = *triangle;
    let Some(axis) = (0..3).find(|&axis| turn(axis, a, b, c) != 0.0) else { return false };
    below(triangle, point) == 0.0 && agree(turns(axis, triangle, point))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: Corners =
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];

    #[test]
    fn the_inner_side_is_that_against_the_normal() {
        assert!(below(&TRIANGLE, Vec3::new(0.2, 0.2, -1.0)) > 0.0);
        assert!(below(&TRIANGLE, Vec3::new(0.2, 0.2, 1e-300)) < 0.0);
        assert_eq!(below(&TRIANGLE, Vec3::new(5.0, 7.0, 0.0)), 0.0);
        assert!(turn(2, TRIANGLE[0], TRIANGLE[1], TRIANGLE[2]) > 0.0);
    }

    #[test]
    fn points_on_a_triangle_are_told_from_those_beside_it_by_one_rounding() {
        let up = |x: f64| f64::from_bits(x.to_bits() + 1);
        assert!(on_triangle(&TRIANGLE, Vec3::new(0.5, 0.5, 0.0)));
        assert!(on_triangle(&TRIANGLE, Vec3::new(0.0, 0.0, 0.0)));
        assert!(!on_triangle(&TRIANGLE, Vec3::new(up(0.5), 0.5, 0.0)));
        assert!(!on_triangle(&TRIANGLE, Vec3::new(0.25, 0.25, f64::MIN_POSITIVE)));
        let upright = TRIANGLE.map(|p| Vec3::new(0.1, p.x, p.y));
        assert!(on_triangle(&upright, Vec3::new(0.1, 0.25, 0.25)));
        assert!(!on_triangle(&upright, Vec3::new(up(0.1), 0.25, 0.25)));
        let needle = [0.0, 1.0, 2.0].map(Vec3::from_element);
        assert!(!on_triangle(&needle, needle[1]));
    }
}
