//! Volume, area, centroid and inertia, by signed tetrahedra.

use crate::vector::{add, cross, dot, norm, scale, sub};
use crate::{Mesh, Vec3};

/// Integrals over a closed mesh, and over its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Volume [m³].
    pub volume: f64,
    /// Area of the surface [m²].
    pub area: f64,
    /// Centre of the volume [m].
    pub centroid: Vec3,
    /// Inertia about the centroid for a density of one [m⁵]: symmetric, off-diagonal entries are
    /// the negative products of inertia.
    pub inertia: [Vec3; 3],
}

impl Mesh {
    /// Volume, area, centroid and inertia.
    ///
    /// Each triangle makes a signed tetrahedron with the middle of the bounds; for one with corners
    /// `0, a, b, c` and `d = a . (b x c)` the volume is `d / 6` and `int x x^T = d / 120 (a a^T + b b^T
    /// + c c^T + s s^T)` with `s = a + b + c` (Blow & Binstock, 2004).
    pub fn moments(&self) -> Moments {
        let origin = self.bounds().centre();
        let (mut volume, mut area, mut first, mut second) = (0.0, 0.0, [0.0; 3], [[0.0; 3]; 3]);
        for triangle in 0..self.triangles.len() {
            let corners @ [a, b, c] = self.corners(triangle).map(|p| sub(p, origin));
            let d = dot(a, cross(b, c));
            let s = add(a, add(b, c));
            volume += d / 6.0;
            area += 0.5 * norm(cross(sub(b, a), sub(c, a)));
            first = add(first, scale(s, d / 24.0));
            for i in 0..3 {
                for j in 0..3 {
                    let squares: f64 = corners.iter().map(|p| p[i] * p[j]).sum();
                    second[i][j] += d / 120.0 * (squares + s[i] * s[j]);
                }
            }
        }
        let middle = scale(first, 1.0 / volume);
        let central = |i: usize, j: usize| second[i][j] - volume * middle[i] * middle[j];
        let trace = central(0, 0) + central(1, 1) + central(2, 2);
        let inertia = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { trace - central(i, i) } else { -central(i, j) })
        });
        Moments { volume, area, centroid: add(middle, origin), inertia }
    }
}

/// Volume that triangles enclose, negative if their normals point inward; best conditioned with an
/// origin in their midst.
pub fn signed_volume(triangles: impl Iterator<Item = [Vec3; 3]>, origin: Vec3) -> f64 {
    let six = triangles.map(|corners| {
        let [a, b, c] = corners.map(|p| sub(p, origin));
        dot(a, cross(b, c))
    });
    six.sum::<f64>() / 6.0
}
