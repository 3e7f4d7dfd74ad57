//! Mass flow rates of sections as means since the frame before.
//!
//! A component gives the mean since the row before, which is often a small part of the time between
//! frames. The total that passed has seen every grain.

use std::collections::BTreeMap;
use tremie_messages::start::Signal;

const RATE: &str = ".mass_flow_rate";
const PASSED: &str = ".mass_passed";

/// Times and totals of the frames before, by component.
#[derive(Default)]
pub struct Rates {
    before: BTreeMap<String, (f64, Vec<f64>)>,
}

/// Place of the total of which signal `k` is the rate, if it is a rate and there is a total.
fn total(signals: &[Signal], k: usize) -> Option<usize> {
    let probe = signals[k].name.strip_suffix(RATE)?;
    signals.iter().position(|other| other.name.strip_suffix(PASSED) == Some(probe))
}

/// True if signal `k` is shown as a mean since the frame before.
pub fn is_mean(signals: &[Signal], k: usize) -> bool {
    total(signals, k).is_some()
}

impl Rates {
    /// The values of a frame of `from` as they are shown.
    pub fn shown(&mut self, from: &str, time: f64, signals: &[Signal], values: &[f64]) -> Vec<f64> {
        let mut shown = values.to_vec();
        let before = self.before.insert(from.into(), (time, values.to_vec()));
        let Some((begin, before)) = before.filter(|(begin, _)| *begin < time) else {
            return shown;
        };
        for (k, value) in shown.iter_mut().enumerate() {
            if let Some(total) = total(signals, k) {
                *value = (values[total] - before[total]) / (time - begin);
            }
        }
        shown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_that_passed_between_frames_is_in_the_rate() {
        let signal = |name: &str, unit: &str| Signal::new(name, unit, &[]);
        let signals = [
            signal("mouth.mass_flow_rate", "kg/s"),
            signal("mouth.crossings", "1"),
            signal("mouth.mass_passed", "kg"),
            signal("inlet.mass_flow_rate", "kg/s"),
        ];
        let mut rates = Rates::default();
        let mut at = |time, values: [f64; 4]| rates.shown("grains", time, &signals, &values);
        assert_eq!(at(0.0, [0.0, 0.0, 0.0, 7.0]), [0.0, 0.0, 0.0, 7.0]);
        // The last row before the frame saw nothing pass.
        assert_eq!(at(0.5, [0.0, -1.0, -2.0, 7.0]), [-4.0, -1.0, -2.0, 7.0]);
        assert_eq!(at(1.0, [0.0, -1.0, -2.0, 7.0]), [0.0, -1.0, -2.0, 7.0]);
        assert!(is_mean(&signals, 0) && !is_mean(&signals, 3));
    }
}
