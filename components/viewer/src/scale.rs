//! Numbers to colours, on a scale that stands still where it can.

use std::sync::LazyLock;

/// Colour of nodes where there is neither fluid nor solid.
pub const AIR: u32 = rgba([46, 52, 60]);
/// Colour of solid nodes and of bodies that never move.
pub(crate) const GREY: u32 = rgba([112, 116, 122]);

/// Packed as Rerun packs colours, opaque.
pub(crate) const fn rgba([r, g, b]: [u8; 3]) -> u32 {
    u32::from_be_bytes([r, g, b, 255])
}

/// A map of colours; both are even in lightness, and differ in hue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Map {
    /// From violet over green to yellow.
    Viridis,
    /// From blue over red to yellow.
    Plasma,
}

/// Coefficients of a polynomial of degree six, for red, green and blue.
type Polynomial = [[f64; 3]; 7];

impl Map {
    /// Colour at `x` in 0..1, by the polynomials of degree six that M. Zucker fitted to the maps
    /// (<https://www.shadertoy.com/view/WlfXRN>, public domain); off by less than 1/255 nearly
    /// everywhere.
    pub fn colour(self, x: f64) -> [u8; 3] {
        const VIRIDIS: Polynomial = [
            [0.2777273272234177, 0.005407344544966578, 0.3340998053353061],
            [0.1050930431085774, 1.404613529898575, 1.384590162594685],
            [-0.3308618287255563, 0.214847559468213, 0.09509516302823659],
            [-4.634230498983486, -5.799100973351585, -19.33244095627987],
            [6.228269936347081, 14.17993336680509, 56.69055260068105],
            [4.776384997670288, -13.74514537774601, -65.35303263337234],
            [-5.435455855934631, 4.645852612178535, 26.3124352495832],
        ];
        const PLASMA: Polynomial = [
            [0.05873234392399702, 0.02333670892565664, 0.5433401826748754],
            [2.176514634195958, 0.2383834171260182, 0.7539604599784036],
            [-2.689460476458034, -7.455851135738909, 3.110799939717086],
            [6.130348345893603, 42.3461881477227, -28.51885465332158],
            [-11.10743619062271, -82.66631109428045, 60.13984767418263],
            [10.02306557647065, 71.4136177009535, -54.07218655560067],
            [-3.658713842777788, -22.93153465461149, 18.19190778539828],
        ];
        let c = match self {
            Self::Viridis => &VIRIDIS,
            Self::Plasma => &PLASMA,
        };
        let x = x.clamp(0.0, 1.0);
        std::array::from_fn(|k| {
            let value = c.iter().rev().fold(0.0, |sum, c| sum * x + c[k]);
            (value.clamp(0.0, 1.0) * 255.0).round() as u8
        })
    }

    /// The map in 256 steps: few distinct colours compress well.
    fn table(self) -> &'static [u32; 256] {
        static VIRIDIS: LazyLock<[u32; 256]> = LazyLock::new(|| steps(Map::Viridis));
        static PLASMA: LazyLock<[u32; 256]> = LazyLock::new(|| steps(Map::Plasma));
        match self {
            Self::Viridis => &VIRIDIS,
            Self::Plasma => &PLASMA,
        }
    }
}

fn steps(map: Map) -> [u32; 256] {
    std::array::from_fn(|k| rgba(map.colour(k as f64 / 255.0)))
}

/// The smallest of 1, 2, 5, 10, 20, .. times a power of ten that is at least `value`.
pub fn round_up(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    // A hair of slack: 5e-3 itself must stay 5e-3, also from single precision.
    let fits = |m: &&f64| **m * decade >= value * (1.0 - 1e-6);
    [1.0, 2.0, 5.0, 10.0].iter().find(fits).map_or(value, |m| m * decade)
}

/// A scale from zero to a round number, of speed for instance.
///
/// It starts at the expected value, is set by the first one above zero, and then only grows: so
/// that a colour means the same throughout nearly all of a run. It follows the value that all but
/// one in a hundred stay below, so that one stray grain does not spoil it.
#[derive(Clone, Debug)]
pub struct Scale {
    map: Map,
    max: f64,
    fixed: bool,
    moving: bool,
    /// True if it begins at the negative of its end.
    signed: bool,
}

impl Scale {
    /// A scale that ends at `fixed`, or else follows the run from `expected` on.
    pub fn new(map: Map, fixed: Option<f64>, expected: Option<f64>) -> Self {
        let start = expected.filter(|v| *v > 0.0).map_or(1e-3, round_up);
        Self {
            map,
            max: fixed.unwrap_or(start),
            fixed: fixed.is_some(),
            moving: false,
            signed: false,
        }
    }

    /// From the negative of its end on, if values of both signs count; their sizes are followed.
    pub fn signed(self, signed: bool) -> Self {
        Self { signed, ..self }
    }

    /// Value at the lower end.
    pub fn min(&self) -> f64 {
        if self.signed { -self.max } else { 0.0 }
    }

    /// Its map of colours.
    pub fn map(&self) -> Map {
        self.map
    }

    /// Value at the upper end.
    pub fn max(&self) -> f64 {
        self.max
    }

    /// Takes the values of a frame into account; their order is lost. Returns whether the scale
    /// changed.
    pub fn follow(&mut self, values: &mut [f32]) -> bool {
        let high = percentile_99(values);
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

    /// Colour of a value; values beyond the end have its colour.
    pub fn colour(&self, value: f32) -> u32 {
        let part = (f64::from(value) - self.min()) / (self.max - self.min());
        self.map.table()[(part * 255.0).clamp(0.0, 255.0) as usize]
    }
}

fn percentile_99(values: &mut [f32]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let k = (values.len() * 99 / 100).min(values.len() - 1);
    f64::from(*values.select_nth_unstable_by(k, f32::total_cmp).1)
}

/// Length of a vector.
pub(crate) fn speed(v: [f32; 3]) -> f32 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_those_that_they_are_called_by() {
        let near = |map: Map, x: f64, expected: [u8; 3]| {
            let found = map.colour(x);
            let is_near = found.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 5);
            assert!(is_near, "{map:?} {x}: {found:?} {expected:?}");
        };
        near(Map::Viridis, 0.0, [68, 1, 84]);
        near(Map::Viridis, 0.5, [33, 145, 140]);
        near(Map::Viridis, 1.0, [253, 231, 37]);
        near(Map::Plasma, 0.0, [13, 8, 135]);
        near(Map::Plasma, 0.5, [204, 71, 120]);
        near(Map::Plasma, 1.0, [240, 249, 33]);
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
        let mut scale = Scale::new(Map::Viridis, None, Some(10.0));
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
        let mut scale = Scale::new(Map::Viridis, None, None);
        scale.follow(&mut speeds);
        assert!((scale.max() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn a_signed_scale_has_nothing_in_its_middle() {
        let mut scale = Scale::new(Map::Viridis, None, None).signed(true);
        scale.follow(&mut [2.0; 10]);
        assert_eq!((scale.min(), scale.max()), (-2.0, 2.0));
        assert_eq!(scale.colour(0.0), Map::Viridis.table()[127]);
        assert_eq!(scale.colour(-3.0), Map::Viridis.table()[0]);
    }

    #[test]
    fn a_fixed_scale_stands_still() {
        let mut scale = Scale::new(Map::Viridis, Some(0.3), None);
        assert!(!scale.follow(&mut [5.0; 10]));
        assert_eq!(scale.max(), 0.3);
        assert_eq!(scale.colour(1.0), scale.colour(0.3));
    }
}
