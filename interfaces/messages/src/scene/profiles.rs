//! Profiles: tables of what grains do in the bins of a box, averaged over time.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A profile of grains: a box cut into bins along one axis or two, in which the grains are sampled
/// now and then, and tables of means over the samples.
///
/// [`crate::frame::ProfileBin`] says what a table holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GrainProfile {
    /// Name, unique among probes, gaps and profiles: letters, digits, `_`.
    pub name: String,
    /// Axes along which bins follow each other, one or two, and the number of bins along each.
    pub axes: Vec<BinnedAxis>,
    /// Lower corner of the box, which lies in the domain [m]. In a plane scene the box is as deep
    /// as the domain.
    pub min: [f64; 3],
    /// Upper corner [m].
    pub max: [f64; 3],
    /// Simulated time at which sampling begins: the first sample comes an interval later [s].
    pub from: f64,
    /// Time between samples [s]; `None`: a window.
    pub every: Option<f64>,
    /// Time over which a table averages [s]; `None`: the rest of the run.
    pub average: Option<f64>,
    /// Velocity that counts.
    pub velocity: ProfileVelocity,
}

/// An axis that is cut into bins of equal width.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BinnedAxis {
    /// The axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Number of bins.
    pub bins: usize,
}

/// Velocity of a grain that counts in a profile.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ProfileVelocity {
    /// The velocity at the sample.
    #[default]
    Instantaneous,
    /// The displacement since the sample before, over the time between: what a camera sees. It
    /// counts in the bin of its middle. A grain that moves by more than half a period between
    /// samples is taken to have gone the shorter way.
    Displacement,
}

/// When a profile is sampled, counted in windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ProfileSchedule {
    /// Window at whose end sampling begins.
    pub begin: u64,
    /// Windows between samples.
    pub every: u64,
    /// Samples of a table; `None` where the table goes on to the end of the run.
    pub samples: Option<u64>,
}

impl GrainProfile {
    /// Most bins of a profile.
    pub const MOST_BINS: usize = 100_000;

    /// Number of bins. Bin `(i, j)` of two axes is number `i * bins of the second + j`.
    pub fn bins(&self) -> usize {
        self.axes.iter().map(|axis| axis.bins).product()
    }

    /// Volume of a bin [m³].
    pub fn bin_volume(&self) -> f64 {
        let whole: f64 = (0..3).map(|a| self.max[a] - self.min[a]).product();
        whole / self.bins() as f64
    }

    /// Edge number `k` of the bins along an axis [m]: bin k holds what lies from edge k up to edge
    /// k + 1, that one excluded.
    pub fn edge(&self, along: BinnedAxis, k: usize) -> f64 {
        let (min, max) = (self.min[along.axis], self.max[along.axis]);
        min + (max - min) * (k as f64 / along.bins as f64)
    }

    /// Middle of bin `k` along an axis [m].
    pub fn middle(&self, along: BinnedAxis, k: usize) -> f64 {
        0.5 * (self.edge(along, k) + self.edge(along, k + 1))
    }

    /// Middle of a bin along each binned axis [m], by its number.
    pub fn middles(&self, bin: usize) -> impl Iterator<Item = f64> + '_ {
        let mut stride = self.bins();
        self.axes.iter().map(move |&along| {
            stride /= along.bins;
            self.middle(along, bin / stride % along.bins)
        })
    }

    /// When it is sampled in a run with windows of a length [s]: times become whole numbers of
    /// windows, and the time of a table a whole number of samples, at least one.
    pub fn schedule(&self, window: f64) -> ProfileSchedule {
        let count = |time: f64, unit: f64| (time / unit).round() as u64;
        let every = self.every.map_or(1, |every| count(every, window).max(1));
        let between = every as f64 * window;
        ProfileSchedule {
            begin: count(self.from, window),
            every,
            samples: self.average.map(|average| count(average, between).max(1)),
        }
    }
}

impl ProfileSchedule {
    /// True if the grains are sampled at the end of a window.
    pub fn is_sample(&self, window: u64) -> bool {
        window > self.begin && (window - self.begin).is_multiple_of(self.every)
    }

    /// Windows of a table; `None` where it goes on to the end of the run.
    pub fn windows(&self) -> Option<u64> {
        self.samples.map(|samples| samples.saturating_mul(self.every))
    }

    /// Tables that a run of so many windows makes, the last one perhaps of fewer samples.
    pub fn tables(&self, windows: u64) -> u64 {
        let samples = windows.saturating_sub(self.begin) / self.every;
        match self.samples {
            Some(of_table) => samples.div_ceil(of_table),
            None => samples.min(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(axes: &[(usize, usize)]) -> GrainProfile {
        GrainProfile {
            name: "p".into(),
            axes: axes.iter().map(|&(axis, bins)| BinnedAxis { axis, bins }).collect(),
            min: [0.0; 3],
            max: [1.0, 2.0, 4.0],
            from: 0.0,
            every: None,
            average: None,
            velocity: ProfileVelocity::default(),
        }
    }

    #[test]
    fn bins_of_two_axes_are_numbered_with_the_second_fastest() {
        let profile = profile(&[(2, 4), (0, 2)]);
        assert_eq!(profile.bins(), 8);
        assert_eq!(profile.bin_volume(), 1.0);
        let middles: Vec<Vec<f64>> = (0..3).map(|bin| profile.middles(bin).collect()).collect();
        assert_eq!(middles, [[0.5, 0.25], [0.5, 0.75], [1.5, 0.25]]);
    }

    #[test]
    fn times_become_whole_numbers_of_windows() {
        let timed = GrainProfile {
            from: 0.5,
            every: Some(1.04e-3),
            average: Some(5e-3),
            ..profile(&[(0, 4)])
        };
        let schedule = timed.schedule(1e-4);
        assert_eq!(schedule, ProfileSchedule { begin: 5000, every: 10, samples: Some(5) });
        assert!(!schedule.is_sample(5000), "sampling begins there, with an interval");
        assert!(schedule.is_sample(5010) && !schedule.is_sample(5011));
        assert_eq!(schedule.windows(), Some(50));
        assert_eq!([5009, 5010, 5050, 5051, 5060].map(|n| schedule.tables(n)), [0, 1, 1, 1, 2]);
        let short = GrainProfile { every: Some(1e-9), ..profile(&[(0, 4)]) }.schedule(1e-4);
        assert_eq!(short, ProfileSchedule { begin: 0, every: 1, samples: None });
        assert_eq!((short.tables(0), short.tables(7)), (0, 1));
    }
}
