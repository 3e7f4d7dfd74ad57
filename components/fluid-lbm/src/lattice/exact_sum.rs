//! Sums that depend on no order: of what links and blocks of cells give, on any number of threads and in any
//! number of parts of the lattice.
//!
//! Numbers are added up as whole multiples of 2^-80 lattice units, in 128 bits, so that nothing is rounded on the
//! way. (Rounding to fixed points before a sum: Demmel & Nguyen 2015, *Parallel Reproducible Summation*.) A sum
//! may grow to 2^46. A number that is not finite, or larger than that, makes the sum no number.

use serde::{Deserialize, Serialize};
use std::ops::AddAssign;

/// Multiples of the unit in 1.
const SCALE: f64 = (1_u128 << 80) as f64;

/// Numbers are less than this.
const LIMIT: f64 = (1_u64 << 46) as f64;

/// Bits of a limb: sums of 2^20 limbs fit in a number of 64 bits.
const LIMB: u32 = 43;

/// Numbers that carry an [`ExactSum`] from one part of a lattice to others.
pub const LIMBS: usize = 4;

/// A sum that depends on no order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ExactSum {
    units: i128,
    is_strange: bool,
}

impl ExactSum {
    /// The sum of one number.
    pub fn of(x: f64) -> Self {
        let mut sum = Self::default();
        sum.add(x);
        sum
    }

    /// Adds a number; what of it is below 2^-80 is cut off.
    #[inline(always)]
    pub fn add(&mut self, x: f64) {
        // False where it is no number.
        if x.abs() < LIMIT {
            self.units = self.units.wrapping_add((x * SCALE) as i128);
        } else {
            self.is_strange = true;
        }
    }

    /// The sum as the nearest number.
    #[inline]
    pub fn value(&self) -> f64 {
        if self.is_strange { f64::NAN } else { self.units as f64 / SCALE }
    }

    /// The multiple of the unit, and whether the sum is no number.
    pub fn parts(&self) -> (i128, bool) {
        (self.units, self.is_strange)
    }

    /// The sum of these parts.
    pub fn from_parts(units: i128, is_strange: bool) -> Self {
        Self { units, is_strange }
    }

    /// Numbers that may be added up with those of other sums, each by itself.
    pub fn limbs(&self) -> [i64; LIMBS] {
        let mask = (1 << LIMB) - 1;
        let low = self.units & mask;
        let middle = self.units >> LIMB & mask;
        let high = self.units >> (2 * LIMB);
        [low as i64, middle as i64, high as i64, i64::from(self.is_strange)]
    }

    /// The sum of which these are the limbs, or sums of limbs.
    pub fn from_limbs([low, middle, high, strange]: [i64; LIMBS]) -> Self {
        let units =
            i128::from(low) + (i128::from(middle) << LIMB) + (i128::from(high) << (2 * LIMB));
        Self { units, is_strange: strange != 0 }
    }
}

impl AddAssign for ExactSum {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.units = self.units.wrapping_add(other.units);
        self.is_strange = self.is_strange || other.is_strange;
    }
}

/// A number to whose last place are 2^-30, and 2^-66: added to another and taken away again, it rounds that to
/// multiples.
const COARSE: f64 = 1.5 * (1_u64 << 22) as f64;
/// See `COARSE`.
const FINE: f64 = 1.5 / (1_u64 << 14) as f64;

/// A number as a whole multiple of a coarse quantum and, of the rest, of a fine one: sums of many such are exact in
/// ordinary numbers, so that they depend on no order (the bins of Demmel & Nguyen 2015). What is below the fine
/// quantum, 2^-66, is cut off; of numbers less than 2^21, 2^18 may be added.
#[inline(always)]
pub fn binned(x: f64) -> [f64; 2] {
    let coarse = (x + COARSE) - COARSE;
    let rest = x - coarse;
    [coarse, (rest + FINE) - FINE]
}

/// An [`ExactSum`] of few numbers in little memory; see [`binned`].
#[derive(Clone, Copy, Debug, Default)]
pub struct BinnedSum([f64; 2]);

impl BinnedSum {
    /// Adds a number.
    #[inline(always)]
    pub fn add(&mut self, x: f64) {
        let [coarse, fine] = binned(x);
        self.0[0] += coarse;
        self.0[1] += fine;
    }

    /// Adds it to a sum of more.
    #[inline]
    pub fn add_to(&self, sum: &mut ExactSum) {
        sum.add(self.0[0]);
        sum.add(self.0[1]);
    }
}

/// Adds a vector, component by component.
#[inline(always)]
pub fn add_vector(sums: &mut [ExactSum; 3], v: [f64; 3]) {
    for a in 0..3 {
        sums[a].add(v[a]);
    }
}

/// The numbers nearest to sums.
#[inline(always)]
pub fn values<const N: usize>(sums: &[ExactSum; N]) -> [f64; N] {
    sums.each_ref().map(ExactSum::value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Any order and any parts give the same bits, and those of the sum that is rounded once.
        #[test]
        fn order_and_parts_do_not_matter(
            numbers in prop::collection::vec(-1e6..1e6_f64, 1..60),
            cut in 0..60_usize,
            small in 1e-9..1.0_f64,
        ) {
            let numbers: Vec<f64> =
                numbers.iter().enumerate().map(|(k, x)| if k % 3 == 0 { x * small } else { *x }).collect();
            let sum = |numbers: &[f64]| {
                let mut sum = ExactSum::default();
                numbers.iter().for_each(|&x| sum.add(x));
                sum
            };
            let whole = sum(&numbers);
            let backwards: Vec<f64> = numbers.iter().rev().copied().collect();
            prop_assert_eq!(whole, sum(&backwards));
            let (left, right) = numbers.split_at(cut.min(numbers.len()));
            let (left, right) = (sum(left), sum(right));
            let limbs: Vec<i64> = left.limbs().iter().zip(right.limbs()).map(|(a, b)| a + b).collect();
            let joined = ExactSum::from_limbs([limbs[0], limbs[1], limbs[2], limbs[3]]);
            prop_assert_eq!(whole, joined);
            let plain: f64 = numbers.iter().sum();
            prop_assert!((whole.value() - plain).abs() <= 1e-9 * (1.0 + plain.abs()));
        }
    }

    #[test]
    fn what_is_no_number_stays_none() {
        let mut sum = ExactSum::of(1.0);
        sum.add(f64::INFINITY);
        sum.add(-3.0);
        assert!(sum.value().is_nan());
        assert!(ExactSum::from_limbs(sum.limbs()).value().is_nan());
        assert_eq!(ExactSum::of(-2.5).value(), -2.5);
    }
}
