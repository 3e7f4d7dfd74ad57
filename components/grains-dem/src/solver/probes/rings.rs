//! Rings: number of spheres in one, and part of its cross-section that they hide along its axis.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use crate::math::debris;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_messages::scene::{Domain, Ring};
use tremie_team::{Cut, Team};

/// A ring with the area of its cross-section that lies in the domain [m²].
#[derive(Clone, Debug)]
pub(super) struct Annulus {
    pub ring: Ring,
    pub area: f64,
}

/// Sums over a block of ids in a ring.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RingSum {
    /// Centres in it.
    number: u64,
    /// Areas of their spheres, seen along the axis [m²].
    area: f64,
}

/// Sums over blocks of ids: `sums` has one entry for each ring and block.
pub(super) fn look(
    rings: &[Annulus],
    sums: &mut [RingSum],
    team: &mut Team,
    bodies: &Bodies,
    bounds: &PeriodicBox,
) {
    if rings.is_empty() {
        return;
    }
    team.for_pieces(Cut::every(sums, rings.len()), |b, sums: &mut [RingSum]| {
        sums.fill(RingSum::default());
        for &slot in &bodies.slot[b * BLOCK..bodies.len().min((b + 1) * BLOCK)] {
            let ball = &bodies.balls[slot as usize];
            for (Annulus { ring, .. }, sum) in rings.iter().zip(&mut *sums) {
                let is_in = |shift: Vec3| ring.holds((ball.x + shift).into());
                if bounds.images().any(is_in) {
                    sum.number += 1;
                    sum.area += debris::projected_area(2.0 * ball.radius);
                }
            }
        }
    });
}

impl Annulus {
    /// Probe of a ring in a domain.
    pub fn new(ring: &Ring, domain: &Domain) -> Self {
        let across = ring.across();
        let centre = across.map(|a| ring.through[a]);
        let [min, max] = [&domain.min, &domain.max].map(|corner| across.map(|a| corner[a]));
        // Through periodic faces the ring goes on.
        let reach =
            |a: usize, from: f64| if domain.is_periodic(across[a]) { f64::MAX } else { from };
        let box_ = [0, 1].map(|a| [-reach(a, centre[a] - min[a]), reach(a, max[a] - centre[a])]);
        let [inner, outer] = ring.radii.map(|r| disc_in_box(r, box_));
        Self { ring: ring.clone(), area: outer - inner }
    }

    /// Number of centres, their projected area, that over the ring's.
    pub fn values<'a>(&self, sums: impl Iterator<Item = &'a RingSum>) -> [f64; 3] {
        let (mut number, mut area) = (0, 0.0);
        for sum in sums {
            number += sum.number;
            area += sum.area;
        }
        [number as f64, area, if self.area > 0.0 { area / self.area } else { 0.0 }]
    }
}

/// Area that a disc about the origin and a box have in common, the box given from lower to upper
/// end along both axes: the sum over strips of equal angles, exact for halves and quarters, else to
/// about 1e-6.
fn disc_in_box(radius: f64, [x, y]: [[f64; 2]; 2]) -> f64 {
    const STRIPS: u32 = 4096;
    let [from, to] = x.map(|x| libm::asin((x / radius).clamp(-1.0, 1.0)));
    let width = (to - from) / f64::from(STRIPS);
    let strip = |k: u32| {
        let half = radius * libm::cos(from + (f64::from(k) + 0.5) * width);
        (half.min(y[1]) - (-half).max(y[0])).max(0.0) * half
    };
    if radius > 0.0 { (0..STRIPS).map(strip).sum::<f64>() * width } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn a_disc_is_cut_by_a_box() {
        let all = [-f64::MAX, f64::MAX];
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 4e-6 * PI, "{found} {expected}")
        };
        near(disc_in_box(2.0, [all, all]), 4.0 * PI);
        near(disc_in_box(2.0, [[0.0, f64::MAX], all]), 2.0 * PI);
        near(disc_in_box(2.0, [all, [-9.0, 0.0]]), 2.0 * PI);
        near(disc_in_box(1.0, [[-0.5, 0.5], [-0.25, 0.75]]), {
            // Of the box, what lies above the circle at both upper corners is missing.
            let f = |x: f64| 0.5 * (x * (1.0 - x * x).sqrt() + x.asin());
            let edge = (1.0f64 - 0.75 * 0.75).sqrt();
            let missing =
                if edge < 0.5 { 2.0 * (0.75 * (0.5 - edge) - (f(0.5) - f(edge))) } else { 0.0 };
            1.0 - missing
        });
        assert_eq!(disc_in_box(1.0, [[1.5, 2.0], all]), 0.0);
    }
}
