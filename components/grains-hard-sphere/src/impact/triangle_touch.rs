//! The moment at which a sphere on a curved path touches a triangle: its face, an edge or a corner.

use crate::Vec3;
use crate::impact::approach::{Approach, first_landing};
use tremie_grains_kit::space::wall_triangle::{Triangle, closest_point};

/// Path of a sphere's centre in the frame of a triangle: `x + v s + a s²/2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentrePath {
    /// Centre at the start [m].
    pub x: Vec3,
    /// Velocity at the start [m/s].
    pub v: Vec3,
    /// Acceleration [m/s²].
    pub a: Vec3,
}

impl CentrePath {
    /// Centre at a moment [m].
    pub fn at(&self, s: f64) -> Vec3 {
        self.x + self.v * s + self.a * (0.5 * s * s)
    }
}

/// First moment, up to `until` [s], at which a sphere of a radius [m] touches a triangle from its
/// free side, and the direction from the triangle to the centre there.
pub fn first_touch(
    path: &CentrePath,
    radius: f64,
    triangle: &Triangle,
    until: f64,
) -> Option<(f64, Vec3)> {
    let mut best = None;
    let mut take = |found: Option<f64>| {
        if let Some(s) = found
            && best.is_none_or(|earliest| s < earliest)
        {
            best = Some(s);
        }
    };
    take(on_face(path, radius, triangle, until));
    let corners = &triangle.corners;
    for k in 0..3 {
        take(on_edge(path, radius, (corners[k], corners[(k + 1) % 3]), until));
        let to_corner = Approach { x: path.x - corners[k], v: path.v, a: path.a, reach: radius };
        take(to_corner.first_touch(until));
    }
    let s = best?;
    let centre = path.at(s);
    let away = centre - closest_point(centre, triangle);
    // From behind there is nothing to touch: the solid is there.
    if away.dot(&triangle.normal) < 0.0 {
        return None;
    }
    let length = away.norm_squared().sqrt();
    Some((s, if length > 0.0 { away / length } else { triangle.normal }))
}

fn on_face(path: &CentrePath, radius: f64, triangle: &Triangle, until: f64) -> Option<f64> {
    let n = &triangle.normal;
    let height = (path.x - triangle.corners[0]).dot(n) - radius;
    // A centre behind the face is on its way from elsewhere.
    if height < -radius {
        return None;
    }
    let s = first_landing(height, path.v.dot(n), path.a.dot(n), until)?;
    let foot = path.at(s) - n * (path.at(s) - triangle.corners[0]).dot(n);
    let on = (closest_point(foot, triangle) - foot).norm_squared();
    (on <= ON_FACE * radius * radius).then_some(s)
}

/// Square of the distance over the radius within which a foot lies on a face: rounding.
const ON_FACE: f64 = 1e-24;

fn on_edge(path: &CentrePath, radius: f64, (from, to): (Vec3, Vec3), until: f64) -> Option<f64> {
    let along = to - from;
    let length = along.norm_squared().sqrt();
    let u = along / length;
    let across = |q: Vec3| q - u * q.dot(&u);
    let axis =
        Approach { x: across(path.x - from), v: across(path.v), a: across(path.a), reach: radius };
    let s = axis.first_touch(until)?;
    let place = (path.at(s) - from).dot(&u);
    (place >= 0.0 && place <= length).then_some(s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn triangle() -> Triangle {
        Triangle::of([Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)])
    }

    proptest! {
        #[test]
        fn at_the_touch_the_distance_is_the_radius_and_never_less_before(
            x in -0.5f64..1.5, y in -0.5f64..1.5, vx in -1.0f64..1.0, vy in -1.0f64..1.0,
            g in 0.1f64..5.0,
        ) {
            let path = CentrePath {
                x: Vec3::new(x, y, 1.0),
                v: Vec3::new(vx, vy, 0.2),
                a: Vec3::new(0.0, 0.0, -g),
            };
            let (radius, triangle) = (0.2, triangle());
            let gap = |s: f64| (path.at(s) - closest_point(path.at(s), &triangle)).norm() - radius;
            let end = first_touch(&path, radius, &triangle, 3.0);
            let until = end.map_or(3.0, |(s, _)| s);
            // Down to the plane: behind it the triangle is not looked at.
            let steps = (0..2000).map(|k| until * f64::from(k) / 2000.0);
            for s in steps.take_while(|&s| path.at(s).z > 0.0) {
                prop_assert!(gap(s) > -1e-9, "{} {}", s, gap(s));
            }
            if let Some((s, n)) = end {
                prop_assert!(gap(s).abs() < 1e-9, "{}", gap(s));
                let away = (path.at(s) - closest_point(path.at(s), &triangle)).normalize();
                prop_assert!((n - away).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn edges_and_corners_are_touched_beside_the_face() {
        let fall = |x: f64, y: f64| {
            let path = CentrePath { x: Vec3::new(x, y, 1.0), v: -Vec3::z(), a: Vec3::zeros() };
            first_touch(&path, 0.2, &triangle(), 5.0)
        };
        let (s, n) = fall(0.25, 0.25).unwrap();
        assert!((s - 0.8).abs() < 1e-15 && n == Vec3::z());
        let (s, n) = fall(0.5, -0.12).unwrap();
        assert!((s - 0.84).abs() < 1e-12 && (n - Vec3::new(0.0, -0.6, 0.8)).norm() < 1e-9);
        let (s, _) = fall(-0.12, -0.09).unwrap();
        assert!((s - (1.0 - (0.04f64 - 0.0225).sqrt())).abs() < 1e-12);
        assert_eq!(fall(1.5, 1.5), None);
    }
}
