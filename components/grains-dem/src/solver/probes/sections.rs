//! Rectangles across an axis: which spheres pass through.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::Bodies;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_team::{Cut, Team};

/// A rectangle across an axis, and the spheres that have passed it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Section {
    axis: usize,
    position: f64,
    min: [f64; 3],
    max: [f64; 3],
    /// In the last window.
    last: SectionSum,
    /// Since the start.
    passed: SectionSum,
    /// Mass that had passed when the mean over time began, and how long ago that was [kg, s].
    mean_from: f64,
    mean_over: f64,
}

/// Centres that passed along the axis, less centres that passed against it.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct SectionSum {
    number: i64,
    /// Their mass [kg].
    mass: f64,
}

impl Section {
    /// Across an axis at a position, between two corners [m].
    pub fn new(axis: usize, position: f64, min: [f64; 3], max: [f64; 3]) -> Self {
        let none = SectionSum::default();
        Self { axis, position, min, max, last: none, passed: none, mean_from: 0.0, mean_over: 0.0 }
    }

    /// Ends a window [s].
    pub fn end(&mut self, duration: f64) {
        self.passed.number += self.last.number;
        self.passed.mass += self.last.mass;
        self.mean_over += duration;
    }

    /// Begins the mean over time anew.
    pub fn restart_mean(&mut self) {
        (self.mean_from, self.mean_over) = (self.passed.mass, 0.0);
    }

    /// Mass flow rate, a mean over the time since it was begun; crossings and mass passed since the
    /// start.
    pub fn values(&self) -> [f64; 3] {
        let passed = self.passed.mass - self.mean_from;
        let rate = if self.mean_over > 0.0 { passed / self.mean_over } else { 0.0 };
        [rate, self.passed.number as f64, self.passed.mass]
    }

    /// Times that a straight way `d` from `x` leads through: 1 along the axis, -1 against it.
    fn crossed(&self, x: Vec3, d: Vec3, bounds: &PeriodicBox) -> i64 {
        let a = self.axis;
        let length = if bounds.periodic[a] { bounds.size[a] } else { 0.0 };
        // Across a periodic face the section is met again, one domain length further.
        let images = if length > 0.0 { &[-1.0, 0.0, 1.0][..] } else { &[0.0] };
        let mut crossed = 0;
        for image in images {
            let ahead = self.position + image * length - x[a];
            let sign =
                i64::from(ahead > 0.0 && d[a] >= ahead) - i64::from(ahead <= 0.0 && d[a] < ahead);
            if sign != 0 {
                let at = bounds.wrap(x + d * (ahead / d[a]));
                let inside = |b: usize| b == a || (at[b] >= self.min[b] && at[b] <= self.max[b]);
                crossed += if (0..3).all(inside) { sign } else { 0 };
            }
        }
        crossed
    }
}

/// Sums what passed since positions were `before`, by rank, and takes the new ones. Ways are
/// straight, and along periodic axes shorter than half the domain.
pub(super) fn pass(
    sections: &mut [Section],
    before: &mut [Vec3],
    sums: &mut [SectionSum],
    team: &mut Team,
    (bodies, mass, bounds): (&Bodies, &[f64], &PeriodicBox),
) {
    let seen = &*sections;
    let pieces = (Cut::every(before, BLOCK), Cut::every(sums, sections.len()));
    team.for_pieces(pieces, |b, (before, sums): (&mut [Vec3], &mut [SectionSum])| {
        sums.fill(SectionSum::default());
        for (rank, before) in (b * BLOCK..).zip(before) {
            let x = bodies.balls[bodies.slot[rank] as usize].x;
            let from = std::mem::replace(before, x);
            let way = bounds.shortest(x - from);
            for (section, sum) in seen.iter().zip(&mut *sums) {
                let crossed = section.crossed(from, way, bounds);
                sum.number += crossed;
                sum.mass += crossed as f64 * mass[rank];
            }
        }
    });
    // Block after block: equal bits on any number of threads.
    let count = sections.len();
    for (k, section) in sections.iter_mut().enumerate() {
        section.last = SectionSum::default();
        for sum in sums.iter().skip(k).step_by(count) {
            section.last.number += sum.number;
            section.last.mass += sum.mass;
        }
    }
}
