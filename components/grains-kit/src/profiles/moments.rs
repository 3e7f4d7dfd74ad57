//! Weighted mean and covariance of velocities, one after the other.

use super::grain_sample::PAIRS;
use serde::{Deserialize, Serialize};

/// Weighted mean of velocities and the sum of the weighted products of their differences from it
/// (West 1979, for each pair of components).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct VelocityMoments {
    weight: f64,
    mean: [f64; 3],
    /// xx, yy, zz, yz, zx, xy.
    scatter: [f64; 6],
}

impl VelocityMoments {
    /// Adds a velocity.
    pub fn add(&mut self, weight: f64, velocity: [f64; 3]) {
        let before = self.weight;
        self.weight += weight;
        let part = weight / self.weight;
        let apart: [f64; 3] = std::array::from_fn(|a| velocity[a] - self.mean[a]);
        for (scatter, (a, b)) in self.scatter.iter_mut().zip(PAIRS) {
            *scatter += before * part * apart[a] * apart[b];
        }
        for (mean, apart) in self.mean.iter_mut().zip(apart) {
            *mean += part * apart;
        }
    }

    /// The mean; not a number without velocities.
    pub fn mean(&self) -> [f64; 3] {
        if self.weight > 0.0 { self.mean } else { [f64::NAN; 3] }
    }

    /// The covariances: xx, yy, zz, yz, zx, xy; not numbers without velocities.
    pub fn covariance(&self) -> [f64; 6] {
        self.scatter.map(|scatter| scatter / self.weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_mean_does_not_drown_a_small_fluctuation() {
        let mut moments = VelocityMoments::default();
        // Mean 1e6 m/s, fluctuation of 1 mm/s: sums of squares would leave nothing of it.
        for k in 0..10_000 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            moments.add(2e-9, [1e6 + sign * 1e-3, 0.0, sign * 2e-3]);
        }
        let [xx, yy, zz, yz, zx, xy] = moments.covariance();
        assert!((xx / 1e-6 - 1.0).abs() < 1e-5, "{xx}");
        assert!((zz / 4e-6 - 1.0).abs() < 1e-9, "{zz}");
        assert!((zx / 2e-6 - 1.0).abs() < 1e-6, "{zx}");
        assert_eq!([yy, yz, xy], [0.0; 3]);
        assert!((moments.mean()[0] - 1e6).abs() < 1e-8);
    }

    #[test]
    fn weights_count() {
        let mut moments = VelocityMoments::default();
        moments.add(3.0, [1.0, 0.0, 0.0]);
        moments.add(1.0, [5.0, 0.0, 0.0]);
        assert_eq!(moments.mean()[0], 2.0);
        assert_eq!(moments.covariance()[0], 0.75 * 1.0 + 0.25 * 9.0);
        assert!(VelocityMoments::default().mean()[0].is_nan());
        assert!(VelocityMoments::default().covariance()[0].is_nan());
    }
}
