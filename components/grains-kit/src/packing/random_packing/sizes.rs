//! Distributions of diameters, by inverse transform: one uniform random number gives one diameter.

use core::f64::consts::{FRAC_1_SQRT_2, PI};
use tremie_messages::scene::{Diameters, SievePoint};

/// A distribution by number, ready to draw from.
#[derive(Clone, Debug)]
pub enum Sizes {
    /// All diameters between two bounds alike.
    Uniform {
        /// The smallest [m].
        min: f64,
        /// The largest [m].
        max: f64,
    },
    /// A normal distribution.
    Normal(CutNormal),
    /// A normal distribution of the logarithm.
    LogNormal(CutNormal),
    /// A sieve curve.
    Sieve(Vec<Stage>),
    /// A list, each entry equally likely [m].
    Listed(Vec<f64>),
}

/// Normal distribution cut at two bounds.
#[derive(Clone, Copy, Debug)]
pub struct CutNormal {
    mean: f64,
    deviation: f64,
    min: f64,
    max: f64,
}

/// Grains between two sieves.
#[derive(Clone, Copy, Debug)]
pub struct Stage {
    /// Share of the number of grains up to its upper end.
    up_to: f64,
    /// Share of the number in it.
    share: f64,
    /// `1/d^3` at its lower and upper end [1/m³].
    inverse_cubes: [f64; 2],
}

/// Least part of a normal distribution that must lie between its bounds.
pub const LEAST_PART: f64 = 1e-6;

impl Sizes {
    /// The distribution of some diameters.
    pub fn new(diameters: &Diameters) -> Self {
        match diameters {
            Diameters::Uniform { min, max } => Self::Uniform { min: *min, max: *max },
            &Diameters::Normal { mean, deviation, min, max } => {
                Self::Normal(CutNormal { mean, deviation, min, max })
            }
            &Diameters::LogNormal { median, spread, min, max } => Self::LogNormal(CutNormal {
                mean: libm::log(median),
                deviation: libm::log(spread),
                min: libm::log(min),
                max: libm::log(max),
            }),
            Diameters::Sieve(points) => Self::Sieve(stages(points)),
            Diameters::Listed(list) => Self::Listed(list.clone()),
        }
    }

    /// The diameter below which the part `unit` of all grains lies, by number [m].
    pub fn at(&self, unit: f64) -> f64 {
        match self {
            Self::Uniform { min, max } => min + (max - min) * unit,
            Self::Normal(normal) => normal.at(unit),
            Self::LogNormal(normal) => libm::exp(normal.at(unit)),
            Self::Sieve(stages) => {
                let stage = stages.partition_point(|stage| stage.up_to <= unit);
                let stage = &stages[stage.min(stages.len() - 1)];
                // Mass spread evenly over ln d is a number density of 1/d^4, whose integral is
                // linear in 1/d^3.
                let [low, high] = stage.inverse_cubes;
                let part = 1.0 - (stage.up_to - unit) / stage.share;
                1.0 / libm::cbrt(low + (high - low) * part.clamp(0.0, 1.0))
            }
            Self::Listed(list) => list[(unit * list.len() as f64) as usize],
        }
    }

    /// Mean volume of a grain [m³], by the midpoint rule over a thousand parts of their number.
    pub fn mean_volume(&self) -> f64 {
        const PARTS: u32 = 1000;
        let volume = |part: u32| {
            let d = self.at((f64::from(part) + 0.5) / f64::from(PARTS));
            PI / 6.0 * d * d * d
        };
        (0..PARTS).map(volume).sum::<f64>() / f64::from(PARTS)
    }

    /// Part of the uncut distribution that lies between its bounds.
    pub fn part_between_bounds(&self) -> f64 {
        match self {
            Self::Normal(normal) | Self::LogNormal(normal) => {
                normal.below(normal.max) - normal.below(normal.min)
            }
            _ => 1.0,
        }
    }
}

impl CutNormal {
    /// Part of the uncut distribution below `x`.
    fn below(&self, x: f64) -> f64 {
        0.5 * libm::erfc((self.mean - x) / self.deviation * FRAC_1_SQRT_2)
    }

    /// Newton's method for the inverse, kept between bounds that close in on it.
    fn at(&self, unit: f64) -> f64 {
        let (mut low, mut high) = (self.min, self.max);
        let (from, to) = (self.below(low), self.below(high));
        let wanted = from + (to - from) * unit;
        let mut x = self.mean.clamp(low, high);
        for _ in 0..64 {
            let over = self.below(x) - wanted;
            if over > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let z = (x - self.mean) / self.deviation;
            let density = libm::exp(-0.5 * z * z) / (self.deviation * (2.0 * PI).sqrt());
            let newton = x - over / density;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if (next - x).abs() <= 1e-14 * self.deviation {
                return next;
            }
            x = next;
        }
        x
    }
}

/// The stages between the points of a sieve curve, those without grains left out.
fn stages(points: &[SievePoint]) -> Vec<Stage> {
    let inverse_cube = |size: f64| 1.0 / (size * size * size);
    let mut stages: Vec<Stage> = points
        .windows(2)
        .filter(|pair| pair[1].passing > pair[0].passing)
        .map(|pair| {
            let [low, high] = [inverse_cube(pair[0].size), inverse_cube(pair[1].size)];
            let mass = pair[1].passing - pair[0].passing;
            let share = mass * (low - high) / libm::log(pair[1].size / pair[0].size);
            Stage { up_to: 0.0, share, inverse_cubes: [low, high] }
        })
        .collect();
    let all: f64 = stages.iter().map(|stage| stage.share).sum();
    let mut sum = 0.0;
    for stage in &mut stages {
        stage.share /= all;
        sum += stage.share;
        stage.up_to = sum;
    }
    if let Some(last) = stages.last_mut() {
        last.up_to = 1.0;
    }
    stages
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Random;

    fn draws(diameters: &Diameters, count: u64) -> Vec<f64> {
        let sizes = Sizes::new(diameters);
        (0..count).map(|index| sizes.at(Random::new(7, index).unit())).collect()
    }

    fn moments(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / n;
        (mean, square.sqrt())
    }

    /// Against the moments of the distribution, within five standard errors of 40,000 draws.
    #[test]
    fn normal_draws_have_its_moments_and_keep_its_bounds() {
        let wide = Diameters::Normal { mean: 3.0, deviation: 0.4, min: 0.5, max: 5.5 };
        let (mean, deviation) = moments(&draws(&wide, 40_000));
        assert!((mean - 3.0).abs() < 5.0 * 0.4 / 200.0, "{mean}");
        assert!((deviation - 0.4).abs() < 5.0 * 0.4 / 283.0, "{deviation}");
        // Cut one deviation either side: variance 1 - 2 phi(1)/(Phi(1) - Phi(-1)) = 0.2911.
        let cut = Diameters::Normal { mean: 3.0, deviation: 0.4, min: 2.6, max: 3.4 };
        let values = draws(&cut, 40_000);
        assert!(values.iter().all(|d| (2.6..=3.4).contains(d)));
        let (mean, deviation) = moments(&values);
        assert!((mean - 3.0).abs() < 5.0 * 0.216 / 200.0, "{mean}");
        assert!((deviation / (0.4 * 0.291_1_f64.sqrt()) - 1.0).abs() < 0.01, "{deviation}");
    }

    #[test]
    fn log_normal_draws_have_its_moments() {
        let spread = 1.3f64;
        let wide = Diameters::LogNormal { median: 2.0, spread, min: 0.2, max: 20.0 };
        let logs: Vec<f64> = draws(&wide, 40_000).iter().map(|d| libm::log(*d)).collect();
        let (mean, deviation) = moments(&logs);
        let sigma = libm::log(spread);
        assert!((mean - libm::log(2.0)).abs() < 5.0 * sigma / 200.0, "{mean}");
        assert!((deviation / sigma - 1.0).abs() < 5.0 / 283.0, "{deviation}");
    }

    /// A one-sided tail: quantiles against the distribution function itself.
    #[test]
    fn the_inverse_inverts() {
        for (min, max) in [(1.0, 7.0), (4.0, 5.0), (3.9, 9.0), (0.1, 2.2)] {
            let normal = CutNormal { mean: 3.0, deviation: 0.4, min, max };
            let (from, to) = (normal.below(min), normal.below(max));
            for k in 0..=100 {
                let unit = f64::from(k) / 100.0;
                let found = (normal.below(normal.at(unit)) - from) / (to - from);
                assert!((found - unit).abs() < 1e-9, "{min} {max}: {unit} {found}");
            }
        }
    }

    #[test]
    fn a_sieve_curve_passes_its_masses() {
        let point = |size, passing| SievePoint { size, passing };
        let points = vec![
            point(1.0, 0.0),
            point(1.5, 0.3),
            point(2.0, 0.3),
            point(2.5, 0.8),
            point(3.0, 1.0),
        ];
        let values = draws(&Diameters::Sieve(points.clone()), 60_000);
        let mass =
            |limit: f64| values.iter().filter(|d| **d <= limit).map(|d| d * d * d).sum::<f64>();
        let whole = mass(f64::INFINITY);
        for p in points {
            let passing = mass(p.size) / whole;
            assert!((passing - p.passing).abs() < 0.01, "{}: {passing}", p.size);
        }
        // The logarithm of size is linear in the mass between points.
        let middle = mass((1.0f64 * 1.5).sqrt()) / whole;
        assert!((middle - 0.15).abs() < 0.01, "{middle}");
    }
}
