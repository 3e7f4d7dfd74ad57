//! Speed to colour: viridis, and a scale that stands still where it can.

use std::sync::LazyLock;

/// Colour of solid nodes and of bodies that never move.
pub(crate) const GREY: u32 = rgba([112, 116, 122]);

/// Packed as Rerun packs colours, opaque.
pub(crate) const fn rgba([r, g, b]: [u8; 3]) -> u32 {
    u32::from_be_bytes([r, g, b, 255])
}

/// Viridis at `x` in 0..1, by the polynomial of degree six that M. Zucker fitted to it
/// (<https://www.shadertoy.com/view/WlfXRN>, public domain); off by less than 1/255 nearly everywhere.
pub fn viridis(x: f64) -> [u8; 3] {
    const C: [[f64; 3]; 7] = [
        [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
        [0.1050930431085774, 1.404613529898575, 1.384590162594685],
        [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
        [-4.634230498983486, -5.799100973351585, -19.33244095627987],
        [6.228269936347081, 14.17993336680509, 56.69055260068105],
        [4.776384997670288, -13.74514537774601, -65.35303263337234],
        [-5.435455855934631, 4.645852612178535, 26.3124352495832],
    ];
    let x = x.clamp(0.0, 1.0);
    std::array::from_fn(|k| {
        let value = C.iter().rev().fold(0.0, |sum, c| sum * x + c[k]);
        (value.clamp(0.0, 1.0) * 255.0).round() as u8
    })
}

/// The map in 256 steps: few distinct colours compress well.
static TABLE: LazyLock<[u32; 256]> =
    LazyLock::new(|| std::array::from_fn(|k| rgba(viridis(k as f64 / 255.0))));

/// The smallest of 1, 2, 5, 10, 20, .. times a power of ten that is at least `value`.
pub fn round_up(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    // A hair of slack: 5e-3 itself must stay 5e-3, also from single precision.
    let fits = |m: &&f64| **m * decade >= value * (1.0 - 1e-6);
    [1.0, 2.0, 5.0, 10.0].iter().find(fits).map_or(value, |m| m * decade)
}

/// The scale of speed: from zero to a round number.
///
/// It starts at the expected speed, is set by the first thing that moves, and then only grows: so
/// that a colour means the same speed throughout nearly all of a run. It follows the speed that all
/// but one in a hundred stay below, so that one stray grain does not spoil it.
#[derive(Clone, Debug)]
pub struct SpeedScale {
    max: f64,
    fixed: bool,
    moving: bool,
}

impl SpeedScale {
    /// A scale that ends at `fixed`, or else follows the run from `expected` on [m/s].
    pub fn new(fixed: Option<f64>, expected: Option<f64>) -> Self {
        let start = expected.filter(|v| *v > 0.0).map_or(1e-3, round_up);
        Self { max: fixed.unwrap_or(start), fixed: fixed.is_some(), moving: false }
    }

    /// Speed at the upper end [m/s].
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Takes the speeds of a frame into account [m/s]; their order is lost. Returns whether the scale changed.
    pub fn follow(&mut self, speeds: &mut [f32]) -> bool {
        let high = percentile_99(speeds);
        if self.fixed || high.is_nan() || high <= 0.0 {
            return false;
        }
        let wanted = round_up(high);
        let grown = if self.moving { wanted.max(self.max) } else { wanted };
        self.moving = true;
        let changed = grown != self.max;
        self.max = grown;
        changed
    }

    /// Colour of a speed; speeds beyond the end have its colour.
    pub fn colour(&self, speed: f32) -> u32 {
        TABLE[(f64::from(speed) / self.max * 255.0).clamp(0.0, 255.0) as usize]
    }
}

fn percentile_99(speeds: &mut [f32]) -> f64 {
    if speeds.is_empty() {
        return 0.0;
    }
    let k = (speeds.len() * 99 / 100).min(speeds.len() - 1);
    f64::from(*speeds.select_nth_unstable_by(k, f32::total_cmp).1)
}

/// Length of a vector.
pub(crate) fn speed(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_ends_where_viridis_ends() {
        let near = |a: [u8; 3], b: [u8; 3]| a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 4);
        assert!(near(viridis(0.0), [68, 1, 84]));
        assert!(near(viridis(0.5), [33, 145, 140]));
        assert!(near(viridis(1.0), [253, 231, 37]));
    }

    #[test]
    fn numbers_at_the_end_are_round() {
        for (value, round) in
            [(0.003, 0.005), (0.005, 0.005), (0.0051, 0.01), (1.0, 1.0), (17.0, 20.0)]
        {
            assert!((round_up(value) / round - 1.0).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn the_scale_grows_and_never_falls() {
        let mut scale = SpeedScale::new(None, Some(10.0));
        assert!(!scale.follow(&mut [0.0; 10]));
        assert!(scale.follow(&mut [0.01; 10]));
        assert_eq!(scale.max(), round_up(0.01));
        assert!(scale.follow(&mut [0.3; 10]));
        assert!(!scale.follow(&mut [0.01; 10]));
        assert_eq!(scale.max(), 0.5);
    }

    #[test]
    fn one_stray_grain_does_not_spoil_it() {
        let mut speeds = [0.1_f32; 1000];
        speeds[7] = 1e6;
        let mut scale = SpeedScale::new(None, None);
        scale.follow(&mut speeds);
        assert!((scale.max() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn a_fixed_scale_stands_still() {
        let mut scale = SpeedScale::new(Some(0.3), None);
        assert!(!scale.follow(&mut [5.0; 10]));
        assert_eq!(scale.max(), 0.3);
        assert_eq!(scale.colour(1.0), scale.colour(0.3));
    }
}
