//! A triangle of a wall, and its point that is closest to a sphere's centre.
//!
//! [`tremie_geometry`] looks for closest points of whole surfaces, and must get the same bits from
//! both sides of an edge, so that it takes edges from the lower vertex on. Contacts settle edges by
//! the points themselves, and need the search that is shorter.

use crate::Vec3;

/// A triangle as a contact sees it.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Corners [m].
    pub corners: [Vec3; 3],
    /// Unit normal, to the side where bodies are.
    pub normal: Vec3,
    /// Edges and corners that nowhere stick out; the edge of a number starts at the corner of that
    /// number.
    pub grooves: Grooves,
}

/// Edges and corners at which the surface nowhere sticks out, but is flat or bends towards the
/// bodies: bits 0 to 2 and 3 to 5. What is closest to one of them on one side of it is closer to
/// the other side, so that nothing touches there alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Grooves(pub u8);

impl Grooves {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// True if a feature, an edge (1) or a corner (2) of a number, is a groove.
    #[inline(always)]
    pub fn has(self, feature: u8, number: u8) -> bool {
        (self.0 >> (3 * (feature - 1) + number)) & 1 != 0
    }
}

impl Triangle {
    /// With these corners, which it has anticlockwise where bodies are.
    pub fn of(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let normal = (b - a).cross(&(c - a));
        let normal = normal * (1.0 / normal.norm_squared().sqrt());
        Self { corners, normal, grooves: Grooves::NONE }
    }
}

/// The point of a triangle that is closest to `x`, on whichever side.
pub fn closest_point(x: Vec3, triangle: &Triangle) -> Vec3 {
    border(x, triangle).map_or_else(
        || x - triangle.normal * (x - triangle.corners[0]).dot(&triangle.normal),
        |(_, _, point)| point,
    )
}

/// Distance of a point from a triangle [m].
pub fn distance(x: Vec3, corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a));
    let normal = normal / normal.norm_squared().sqrt();
    let triangle = Triangle { corners, normal, grooves: Grooves::NONE };
    (closest_point(x, &triangle) - x).norm_squared().sqrt()
}

/// The point of a triangle's border that is closest to `x`, whether it is on an edge, 1, or a
/// corner, 2, and on which; none where the closest point lies within (Ericson, *Real-Time Collision
/// Detection*, 2005, sec. 5.1.5).
#[inline(always)]
pub fn border(x: Vec3, triangle: &Triangle) -> Option<(u8, u8, Vec3)> {
    let [a, b, c] = triangle.corners;
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let (ap, bp, cp) = (x - a, x - b, x - c);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    let (vc, vb, va) = (d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4);
    if d1 <= 0.0 && d2 <= 0.0 {
        Some((2, 0, a))
    } else if d3 >= 0.0 && d4 <= d3 {
        Some((2, 1, b))
    } else if d6 >= 0.0 && d5 <= d6 {
        Some((2, 2, c))
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        Some((1, 0, a + ab * (d1 / (d1 - d3))))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        Some((1, 2, a + ac * (d2 / (d2 - d6))))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        Some((1, 1, b + bc * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))))
    } else {
        None
    }
}
