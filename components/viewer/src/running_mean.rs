//! Running means of signals that ring: forces of contacts swing faster than anything else in a run,
//! and what counts is what they swing about.

use crate::signals::path;
use std::collections::{BTreeMap, VecDeque};
use tremie_messages::start::Signal;

/// Frames that a mean is over.
const FRAMES: usize = 16;
/// Turns of the curve within them from which on it rings, of 14 that there can be.
const TURNS: usize = 6;
/// Least swing over the greatest size that counts: noise of rounding is no ringing.
const SWING: f64 = 0.02;

/// A signal whose mean is drawn where it rings.
fn may_ring(signal: &Signal) -> bool {
    signal.unit == "N"
}

/// Values of a signal in the last frames, with their times [s] and windows.
#[derive(Default)]
struct Recent {
    values: VecDeque<(f64, u64, f64)>,
    rings: bool,
}

/// A mean in the middle of the frames that it is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// Simulated time [s].
    pub time: f64,
    /// Window.
    pub window: u64,
    /// The mean.
    pub value: f64,
    /// True for the first of a signal.
    pub is_first: bool,
}

/// Means of all signals that ring, by entity.
#[derive(Default)]
pub struct RunningMeans {
    recent: BTreeMap<String, Recent>,
}

impl RunningMeans {
    /// Takes the signals of a component at a time [s] and window: the entities of those that ring, and
    /// their means.
    pub fn of_signals(
        &mut self,
        from: &str,
        at: (f64, u64),
        signals: &[Signal],
        values: &[f64],
    ) -> Vec<(String, Mean)> {
        let mut means = Vec::new();
        for (signal, value) in signals.iter().zip(values).filter(|(signal, _)| may_ring(signal)) {
            let path = path(from, &signal.name);
            means.extend(self.take(&path, at, *value).map(|mean| (path, mean)));
        }
        means
    }

    /// Takes a value of the signal at an entity; its mean, if it rings or has rung.
    fn take(&mut self, path: &str, (time, window): (f64, u64), value: f64) -> Option<Mean> {
        if !value.is_finite() {
            return None;
        }
        if !self.recent.contains_key(path) {
            self.recent.insert(path.to_string(), Recent::default());
        }
        self.recent.get_mut(path)?.take(time, window, value)
    }
}

impl Recent {
    fn take(&mut self, time: f64, window: u64, value: f64) -> Option<Mean> {
        self.values.push_back((time, window, value));
        if self.values.len() > FRAMES {
            self.values.pop_front();
        }
        if self.values.len() < FRAMES {
            return None;
        }
        let before = self.rings;
        self.rings = before || self.swings();
        let sum: f64 = self.values.iter().map(|(.., value)| value).sum();
        let (time, window, _) = self.values[FRAMES / 2];
        let mean = Mean { time, window, value: sum / FRAMES as f64, is_first: !before };
        self.rings.then_some(mean)
    }

    fn swings(&self) -> bool {
        let value = |k: usize| self.values[k].2;
        let turns = (1..self.values.len() - 1)
            .filter(|&k| (value(k) - value(k - 1)) * (value(k + 1) - value(k)) < 0.0);
        let all = || (0..self.values.len()).map(value);
        let (low, high) = (all().fold(f64::MAX, f64::min), all().fold(f64::MIN, f64::max));
        turns.count() >= TURNS && high - low > SWING * low.abs().max(high.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn last(value: impl Fn(usize) -> f64) -> Option<Mean> {
        let mut means = RunningMeans::default();
        (0..40).filter_map(|k| means.take("force", (k as f64, k as u64), value(k))).last()
    }

    #[test]
    fn a_curve_that_rings_has_a_mean_and_one_that_bends_has_none() {
        let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mean = last(|k| 5.0 + sign(k)).unwrap();
        assert_eq!((mean.value, mean.time, mean.window), (5.0, 32.0, 32));
        assert_eq!(last(|k| (0.2 * k as f64).sin()), None);
        assert_eq!(last(|k| 5.0 + 1e-6 * sign(k)), None, "noise");
        assert_eq!(last(|_| f64::NAN), None);
    }
}
