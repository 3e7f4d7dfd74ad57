//! Grains that are stuck between a seat and what closes on it (Mutabaruka & Kamrin, *Comput. Part.
//! Mech.* 5, 2018, appendix B).

use core::f64::consts::PI;

/// Area of a sphere seen from any side [m²].
pub fn projected_area(diameter: f64) -> f64 {
    0.25 * PI * diameter * diameter
}

/// Normalised area of stuck particles: that of all spheres seen along the normal of the seat, over
/// the area of the seat [m²].
pub fn normalised_area(diameters: impl IntoIterator<Item = f64>, seat: f64) -> f64 {
    diameters.into_iter().map(projected_area).fold(0.0, |sum, area| sum + area) / seat
}
