//! Debris of grains that are stuck between a seat and what closes on it (Mutabaruka & Kamrin,
//! *Comput. Part. Mech.* 5, 2018, appendix B).

/// Debris if all stuck grains break [cubes of a grain's diameter] (Eq. 34). Its volume is the
/// projected area of the grains, `normalised_area` of the `seat` [m²], times the `lift` [m]. It is
/// divided by the cube of the `diameter` [m].
pub fn debris(lift: f64, seat: f64, normalised_area: f64, diameter: f64) -> f64 {
    lift * seat * normalised_area / (diameter * diameter * diameter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Least normalised area of a slurry of the solid fraction `fraction` under a closure that one
    /// layer of grains holds open, over a cone that rises by `slope` [rad] (Eq. 33).
    fn least_normalised_area(fraction: f64, slope: f64) -> f64 {
        1.5 * fraction / libm::cos(slope)
    }

    /// A square grid of spheres, one in each square of edge 2 d, hides a part of pi/16; it is stuck
    /// at the lift that lets one sphere through a gap along a cone.
    #[test]
    fn a_known_layer_has_its_area_and_debris() {
        let (d, slope) = (0.8e-3, 29.53f64.to_radians());
        let seat = 400.0 * (2.0 * d) * (2.0 * d);
        let nasp = 400.0 * 0.25 * PI * d * d / seat;
        assert!((nasp - PI / 16.0).abs() < 1e-12, "{nasp}");
        // As a layer as high as the lift, the grid has the solid fraction for which the bound is
        // sharp.
        let lift = d / slope.cos();
        let fraction = 400.0 * PI / 6.0 * d * d * d / (lift * seat);
        assert!((least_normalised_area(fraction, slope) - nasp).abs() < 1e-12);
        let found = debris(lift, seat, nasp, d);
        // Eq. 35.
        let expected = 1.5 * seat * fraction / (slope.cos() * slope.cos() * d * d);
        assert!((found / expected - 1.0).abs() < 1e-12, "{found}");
        // 1.72 phi, as printed.
        assert!((least_normalised_area(1.0, slope) - 1.72).abs() < 5e-3);
    }
}
