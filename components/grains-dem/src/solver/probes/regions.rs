//! Boxes: solid fraction and velocity of the spheres inside.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_team::{Cut, Team};

/// A box [m].
#[derive(Clone, Copy, Debug)]
pub(super) struct ProbeRegion {
    pub min: Vec3,
    pub max: Vec3,
}

/// Sums over a block of ids in a region.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RegionSum {
    /// Volume of spheres in it [m³].
    volume: f64,
    /// Volume times velocity of these spheres [m⁴/s].
    flow: Vec3,
    /// Centres in it.
    number: u64,
}

/// Sums over blocks of ids; `parts` of the volumes count, by rank, or all of them. `sums` has one
/// entry for each region and block.
pub(super) fn look(
    regions: &[ProbeRegion],
    sums: &mut [RegionSum],
    team: &mut Team,
    (bodies, parts): (&Bodies, &[f64]),
    bounds: &PeriodicBox,
) {
    if regions.is_empty() {
        return;
    }
    team.for_pieces(Cut::every(sums, regions.len()), |b, sums: &mut [RegionSum]| {
        sums.fill(RegionSum::default());
        let own = b * BLOCK..bodies.len().min((b + 1) * BLOCK);
        for (rank, &slot) in own.clone().zip(&bodies.slot[own]) {
            let part = parts.get(rank).copied().unwrap_or(1.0);
            let (ball, twist) = (&bodies.balls[slot as usize], &bodies.twists[slot as usize]);
            let radius = bodies.equal_radius(slot as usize);
            for (region, sum) in regions.iter().zip(&mut *sums) {
                for shift in bounds.images() {
                    let volume = part * region.volume_of(ball.x + shift, radius);
                    sum.volume += volume;
                    sum.flow += twist.v * volume;
                }
                sum.number += u64::from(region.holds(ball.x));
            }
        }
    });
}

impl ProbeRegion {
    /// Volume of a sphere in the region [m³].
    fn volume_of(&self, x: Vec3, radius: f64) -> f64 {
        super::volume_in_box(radius, x, self.min, self.max)
    }

    /// True if a centre lies in it; regions side by side never share one.
    fn holds(&self, x: Vec3) -> bool {
        (0..3).all(|a| x[a] >= self.min[a] && x[a] < self.max[a])
    }

    /// Solid fraction, number of centres, mean velocity of the volume filled: 0 where there is
    /// none.
    pub fn values<'a>(&self, sums: impl Iterator<Item = &'a RegionSum>) -> [f64; 5] {
        let mut all = RegionSum::default();
        for sum in sums {
            all.volume += sum.volume;
            all.flow += sum.flow;
            all.number += sum.number;
        }
        let size = self.max - self.min;
        let mean = if all.volume > 0.0 { all.flow / all.volume } else { Vec3::zeros() };
        let fraction = all.volume / (size.x * size.y * size.z);
        [fraction, all.number as f64, mean.x, mean.y, mean.z]
    }
}
