//! The volume that a sphere and a box have in common.

use core::f64::consts::PI;

/// Slices of a sphere that more than one pair of the box's faces cuts.
const SLICES: i32 = 48;

/// Volume of the part of a sphere that lies in a box [m³]. `low` and `high` are the box's corners
/// as seen from the sphere's centre. Exact where the faces across one axis alone cut the sphere;
/// else the sum of exact areas of slices, to 1e-4 of the sphere.
pub(crate) fn of_sphere_and_box(radius: f64, low: [f64; 3], high: [f64; 3]) -> f64 {
    if (0..3).any(|a| low[a] >= radius || high[a] <= -radius) {
        return 0.0;
    }
    let cuts = |a: usize| low[a] > -radius || high[a] < radius;
    match [0, 1, 2].map(cuts) {
        [false, false, false] => 4.0 / 3.0 * PI * radius.powi(3),
        [true, false, false] => layer(radius, low[0], high[0]),
        [false, true, false] => layer(radius, low[1], high[1]),
        [false, false, true] => layer(radius, low[2], high[2]),
        _ => slices(radius, low, high),
    }
}

/// Volume of a sphere between two planes at distances from its centre.
fn layer(r: f64, low: f64, high: f64) -> f64 {
    let up_to = |h: f64| {
        let h = h.clamp(-r, r);
        PI * (r * r * h - h * h * h / 3.0)
    };
    up_to(high) - up_to(low)
}

/// Midpoint rule over the angle from the middle of the sphere, which is smooth at its poles.
fn slices(r: f64, low: [f64; 3], high: [f64; 3]) -> f64 {
    let angle = |z: f64| libm::asin(z.clamp(-r, r) / r);
    let (from, to) = (angle(low[2]), angle(high[2]));
    let step = (to - from) / f64::from(SLICES);
    let slice = |k: i32| {
        let radius = r * libm::cos(from + (f64::from(k) + 0.5) * step);
        disc(radius, low, high) * radius
    };
    (0..SLICES).map(slice).sum::<f64>() * step
}

/// Area of a disc about the origin in a rectangle.
fn disc(r: f64, low: [f64; 3], high: [f64; 3]) -> f64 {
    let below = |x: f64, y: f64| quadrant(r, x.clamp(-r, r), y.clamp(-r, r));
    below(high[0], high[1]) - below(low[0], high[1]) - below(high[0], low[1])
        + below(low[0], low[1])
}

/// Area of the part of a disc whose coordinates are below `x` and `y`, both in `[-r, r]`.
fn quadrant(r: f64, x: f64, y: f64) -> f64 {
    // Twice the area between the axis and a chord.
    let strip = |t: f64| t * (r * r - t * t).max(0.0).sqrt() + r * r * libm::asin(t / r);
    let half = 0.5 * PI * r * r;
    if x * x + y * y < r * r {
        return x * y + 0.5 * (strip(x) + strip(y) + half);
    }
    match (x >= 0.0, y >= 0.0) {
        (true, true) => strip(x) + strip(y),
        (true, false) => strip(y) + half,
        (false, true) => strip(x) + half,
        (false, false) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_grains_kit::math::random::Random;

    #[test]
    fn boxes_share_a_sphere_among_them() {
        let r = 0.7;
        let whole = 4.0 / 3.0 * PI * r * r * r;
        // Cuts of the sphere in each direction; the pieces between them fill it.
        let edges = [[-1.0, -0.31, 0.2, 1.0], [-1.0, -0.1, 0.55, 1.0], [-1.0, 0.0, 0.4, 1.0]];
        let mut sum = 0.0;
        for k in 0..27 {
            let at = [k % 3, k / 3 % 3, k / 9];
            let low = [0, 1, 2].map(|a| edges[a][at[a]]);
            let high = [0, 1, 2].map(|a| edges[a][at[a] + 1]);
            sum += of_sphere_and_box(r, low, high);
        }
        assert!((sum / whole - 1.0).abs() < 1e-4, "{}", sum / whole);
        let octant = of_sphere_and_box(r, [0.0; 3], [1.0; 3]);
        assert!((8.0 * octant / whole - 1.0).abs() < 1e-3, "{}", 8.0 * octant / whole);
        let cap = of_sphere_and_box(r, [0.3, -1.0, -1.0], [1.0; 3]);
        let h = r - 0.3;
        assert!((cap / (PI * h * h * (r - h / 3.0)) - 1.0).abs() < 1e-14);
        assert_eq!(of_sphere_and_box(r, [0.7, -1.0, -1.0], [1.0; 3]), 0.0);
    }

    #[test]
    fn pieces_are_what_random_points_say() {
        let (low, high) = ([-0.5, -0.2, -2.0], [0.1, 0.6, 0.3]);
        let mut random = Random::new(1, 0);
        let (mut inside, points) = (0, 400_000);
        for _ in 0..points {
            let p = [(); 3].map(|()| 2.0 * random.unit() - 1.0);
            let in_box = (0..3).all(|a| p[a] > low[a] && p[a] < high[a]);
            inside += i32::from(in_box && p.iter().map(|c| c * c).sum::<f64>() < 1.0);
        }
        let expected = 8.0 * f64::from(inside) / f64::from(points);
        // Three standard deviations of the count.
        let found = of_sphere_and_box(1.0, low, high);
        assert!((found - expected).abs() < 3.0 * 8.0 * 0.3 / f64::from(points).sqrt(), "{found}");
    }
}
