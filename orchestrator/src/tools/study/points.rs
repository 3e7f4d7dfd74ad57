//! Points of a study: all combinations of the rows of its axes.

use rand_chacha::{ChaCha8Rng, rand_core::Rng, rand_core::SeedableRng};

/// Spacing of values between two bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Even distances.
    Even,
    /// Even ratios; both bounds are above zero.
    Log,
    /// Uniformly random, by a seed.
    Random(u64),
}

/// `count` values from `from` to `to`; both bounds are among them, unless the values are random.
pub fn spread(spacing: Spacing, from: f64, to: f64, count: u32) -> Vec<f64> {
    let part = |k: u32| f64::from(k) / f64::from(count.saturating_sub(1).max(1));
    match spacing {
        Spacing::Even => (0..count).map(|k| rounded(from + (to - from) * part(k))).collect(),
        Spacing::Log => (0..count).map(|k| rounded(from * libm::pow(to / from, part(k)))).collect(),
        Spacing::Random(seed) => {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let mut unit = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            (0..count).map(|_| rounded(from + (to - from) * unit())).collect()
        }
    }
}

/// The value with twelve digits: 0.3 where sums give 0.30000000000000004.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Number of all combinations of axes with so many rows; `None` if it is too large to be counted.
pub fn count(rows: &[usize]) -> Option<usize> {
    rows.iter().try_fold(1usize, |count, rows| count.checked_mul(*rows))
}

/// Row of each axis at a point, counted from 0; the last axis changes fastest.
pub fn rows_at(mut point: usize, rows: &[usize]) -> Vec<usize> {
    let mut at = vec![0; rows.len()];
    for (place, rows) in at.iter_mut().zip(rows).rev() {
        *place = point % rows.max(&1);
        point /= rows.max(&1);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn points_are_all_combinations_and_the_last_axis_changes_fastest() {
        let rows = [2, 3];
        let all: Vec<_> = (0..count(&rows).unwrap()).map(|point| rows_at(point, &rows)).collect();
        assert_eq!(all, [[0, 0], [0, 1], [0, 2], [1, 0], [1, 1], [1, 2]]);
        assert_eq!((count(&[]), rows_at(0, &[])), (Some(1), Vec::new()));
        assert_eq!(count(&[usize::MAX, 2]), None);
    }

    #[test]
    fn values_are_spread_evenly_and_by_ratios() {
        assert_eq!(spread(Spacing::Even, 10.0, 30.0, 3), [10.0, 20.0, 30.0]);
        assert_eq!(spread(Spacing::Even, 0.1, 0.3, 3), [0.1, 0.2, 0.3]);
        assert_eq!(spread(Spacing::Log, 1e-3, 10.0, 5), [1e-3, 1e-2, 0.1, 1.0, 10.0]);
        assert_eq!(spread(Spacing::Even, 4.0, 9.0, 1), [4.0]);
    }

    #[test]
    fn random_values_repeat_with_their_seed() {
        let draw = |seed| spread(Spacing::Random(seed), 1.0, 2.0, 50);
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
        assert!(draw(7).iter().all(|value| (1.0..2.0).contains(value)));
        // More of them begin with the same ones.
        assert_eq!(spread(Spacing::Random(7), 1.0, 2.0, 60)[..50], draw(7));
    }

    proptest! {
        #[test]
        fn each_combination_is_one_point(rows in proptest::collection::vec(1usize..5, 0..5)) {
            let all: std::collections::BTreeSet<_> =
                (0..count(&rows).unwrap()).map(|point| rows_at(point, &rows)).collect();
            prop_assert_eq!(all.len(), rows.iter().product::<usize>());
            prop_assert!(all.iter().all(|at| at.iter().zip(&rows).all(|(at, rows)| at < rows)));
        }

        #[test]
        fn spread_values_lie_within_their_bounds(
            from in 1e-6..1e6f64, more in 1.1..1e3f64, count in 2u32..50, seed: u64,
        ) {
            let to = from * more;
            for spacing in [Spacing::Even, Spacing::Log, Spacing::Random(seed)] {
                let values = spread(spacing, from, to, count);
                let within = |value: &f64| (from * (1.0 - 1e-9)..=to * (1.0 + 1e-9)).contains(value);
                prop_assert!(values.iter().all(within), "{:?}: {:?}", spacing, values);
                if !matches!(spacing, Spacing::Random(_)) {
                    prop_assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
                }
            }
        }
    }
}
