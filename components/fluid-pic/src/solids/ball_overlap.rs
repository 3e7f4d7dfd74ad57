//! Exact overlaps of discs and spheres with faces and cells that lie along the axes.

/// Length of the segment from `lower` to `upper` along one axis that lies in a disc or sphere of
/// `radius`; its line passes the centre at `distance`. Coordinates are relative to the centre.
pub fn segment_in_ball(radius: f64, distance2: f64, lower: f64, upper: f64) -> f64 {
    let half2 = radius * radius - distance2;
    if half2 <= 0.0 {
        return 0.0;
    }
    let half = half2.sqrt();
    (upper.min(half) - lower.max(-half)).max(0.0)
}

/// Area that a disc of `radius` about the origin shares with a rectangle.
///
/// Along the first axis the shared height is that of the rectangle, or ends at the circle; between
/// the abscissas where this changes it is integrated exactly.
pub fn disc_in_rectangle(radius: f64, lower: [f64; 2], upper: [f64; 2]) -> f64 {
    let (begin, end) = (lower[0].max(-radius), upper[0].min(radius));
    if begin >= end || lower[1] >= radius || upper[1] <= -radius {
        return 0.0;
    }
    let mut cuts = [begin, end, begin, begin, begin, begin];
    let mut count = 2;
    for y in [lower[1], upper[1]] {
        let across = radius * radius - y * y;
        if across > 0.0 {
            for x in [-across.sqrt(), across.sqrt()] {
                if x > begin && x < end {
                    cuts[count] = x;
                    count += 1;
                }
            }
        }
    }
    let cuts = &mut cuts[..count];
    cuts.sort_by(f64::total_cmp);
    let height = |x: f64| (radius * radius - x * x).max(0.0).sqrt();
    // Area below the circle from 0 to x.
    let below = |x: f64| {
        let sine = (x / radius).clamp(-1.0, 1.0);
        0.5 * (x * height(x) + radius * radius * libm::asin(sine))
    };
    let mut area = 0.0;
    for pair in cuts.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let middle = height(0.5 * (a + b));
        if middle <= lower[1] || -middle >= upper[1] {
            continue;
        }
        let arc = below(b) - below(a);
        let top = if middle < upper[1] { arc } else { upper[1] * (b - a) };
        let bottom = if -middle > lower[1] { -arc } else { lower[1] * (b - a) };
        area += top - bottom;
    }
    area
}

/// Nodes and weights of Gauss's rule on four points of [-1, 1].
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
];

/// Volume that a sphere of `radius` about the origin shares with a box: areas of slices, by
/// Gauss's rule. Of a box of a tenth of the radius the error is below 1e-4 of the box.
pub fn sphere_in_box(radius: f64, lower: [f64; 3], upper: [f64; 3]) -> f64 {
    let (begin, end) = (lower[2].max(-radius), upper[2].min(radius));
    if begin >= end {
        return 0.0;
    }
    let (middle, half) = (0.5 * (begin + end), 0.5 * (end - begin));
    let slice = |&(node, weight): &(f64, f64)| {
        let z = middle + half * node;
        let across = (radius * radius - z * z).max(0.0).sqrt();
        half * weight * disc_in_rectangle(across, [lower[0], lower[1]], [upper[0], upper[1]])
    };
    GAUSS.iter().map(slice).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    #[test]
    fn a_disc_shares_all_of_itself_with_a_large_rectangle() {
        assert!((disc_in_rectangle(1.0, [-2.0, -2.0], [2.0, 2.0]) - PI).abs() < 1e-14);
        assert!((disc_in_rectangle(1.0, [0.0, -2.0], [2.0, 2.0]) - 0.5 * PI).abs() < 1e-14);
        assert!((disc_in_rectangle(1.0, [0.0, 0.0], [2.0, 2.0]) - 0.25 * PI).abs() < 1e-14);
        assert_eq!(disc_in_rectangle(1.0, [-0.1, -0.1], [0.1, 0.1]), 0.04000000000000001);
        assert_eq!(disc_in_rectangle(1.0, [0.8, 0.8], [2.0, 2.0]), 0.0);
    }

    proptest! {
        /// A rectangle that is cut in four shares what its quarters share.
        #[test]
        fn quarters_add_up(
            x in -1.5..1.5_f64, y in -1.5..1.5_f64, w in 0.01..2.0_f64, h in 0.01..2.0_f64,
            s in 0.0..1.0_f64, t in 0.0..1.0_f64,
        ) {
            let whole = disc_in_rectangle(1.0, [x, y], [x + w, y + h]);
            let (cx, cy) = (x + s * w, y + t * h);
            let quarters = disc_in_rectangle(1.0, [x, y], [cx, cy])
                + disc_in_rectangle(1.0, [cx, y], [x + w, cy])
                + disc_in_rectangle(1.0, [x, cy], [cx, y + h])
                + disc_in_rectangle(1.0, [cx, cy], [x + w, y + h]);
            prop_assert!((whole - quarters).abs() < 1e-13);
            prop_assert!(whole >= 0.0 && whole <= (w * h).min(PI) + 1e-13);
        }

        /// Cells of a box add up to the sphere.
        #[test]
        fn cells_add_up_to_the_sphere(x in 0.0..0.2_f64, y in 0.0..0.2_f64, z in 0.0..0.2_f64) {
            let mut sum = 0.0;
            for i in -7..7 {
                for j in -7..7 {
                    for k in -7..7 {
                        let lower = [x + 0.2 * f64::from(i), y + 0.2 * f64::from(j), z + 0.2 * f64::from(k)];
                        sum += sphere_in_box(1.0, lower, lower.map(|x| x + 0.2));
                    }
                }
            }
            prop_assert!((sum - 4.0 / 3.0 * PI).abs() < 2e-4, "{sum}");
        }
    }
}
