//! Stop conditions of a manifest, which end a run early.

use crate::manifest::{Limit, StopCondition};
use std::collections::BTreeMap;
use tremie_messages::start::Signal;
use tremie_state::{StateError, StateExchange};

/// Watches the conditions as rows of signals come.
#[derive(Debug)]
pub struct StopConditions {
    conditions: Vec<WatchedSignal>,
}

#[derive(Debug)]
struct WatchedSignal {
    condition: StopCondition,
    /// Index of its signal in a row. `sampled`: the signal is measured in some windows only.
    place: usize,
    sampled: bool,
    /// Simulated time since which it has held.
    since: Option<f64>,
}

impl StopConditions {
    /// Watches `conditions`; `signals` gives the full names (`component.signal`) of a row's values.
    /// Conditions on other names were refused by the plan.
    pub fn new(conditions: &[StopCondition], signals: &[(String, Signal)]) -> Self {
        let watched = |c: &StopCondition| {
            let name = format!("{}.{}", c.component, c.signal);
            let place = signals.iter().position(|(known, _)| *known == name)?;
            let sampled = signals[place].1.sampled;
            Some(WatchedSignal { condition: c.clone(), place, sampled, since: None })
        };
        Self { conditions: conditions.iter().filter_map(watched).collect() }
    }

    /// Keeps since when each condition has held, or puts it back. Conditions that are new hold from now on.
    ///
    /// # Errors
    /// A damaged state.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let told = self.conditions.iter().map(|watched| (watched.key(), watched.since));
        let mut since: BTreeMap<String, Option<f64>> = told.collect();
        state.value("since", &mut since)?;
        for watched in &mut self.conditions {
            watched.since = since.get(&watched.key()).copied().flatten();
        }
        Ok(())
    }

    /// True if there are no conditions.
    pub fn is_idle(&self) -> bool {
        self.conditions.is_empty()
    }

    /// Takes the row of simulated time `time` [s]; returns the condition that it meets, if there is
    /// one.
    pub fn look(&mut self, time: f64, values: &[f64]) -> Option<String> {
        self.conditions.iter_mut().find_map(|watched| watched.look(time, values))
    }
}

impl WatchedSignal {
    /// What tells the condition from others.
    fn key(&self) -> String {
        format!("{:?}", self.condition)
    }

    fn look(&mut self, time: f64, values: &[f64]) -> Option<String> {
        let StopCondition { component, signal, limit, after, hold } = &self.condition;
        let value = values[self.place];
        if self.sampled && value.is_nan() {
            // Not measured in this window.
            return None;
        }
        if time < *after || !limit.is_met_by(value) {
            self.since = None;
            return None;
        }
        let since = *self.since.get_or_insert(time);
        let (word, bound) = match limit {
            Limit::Below(bound) => ("below", bound),
            Limit::Above(bound) => ("above", bound),
        };
        // A tolerance of the last bits: `time` is a product, `hold` a number of the manifest.
        let held = time - since >= hold * (1.0 - 1e-9);
        held.then(|| format!("{component}.{signal} = {value:.6e} is {word} {bound} at {time:.6} s"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watch(after: f64, hold: f64) -> StopConditions {
        let condition = StopCondition {
            component: "grains".into(),
            signal: "speed".into(),
            limit: Limit::Below(1.0),
            after,
            hold,
        };
        let signal = |name: &str| (name.to_string(), Signal::new(name, "1", &[]));
        StopConditions::new(&[condition], &["fluid.mass", "grains.speed"].map(signal))
    }

    #[test]
    fn is_met_only_after_its_time() {
        let mut watch = watch(0.5, 0.0);
        assert_eq!(watch.look(0.4, &[9.0, 0.0]), None);
        assert_eq!(watch.look(0.5, &[9.0, 2.0]), None);
        assert!(watch.look(0.6, &[9.0, 0.5]).unwrap().contains("grains.speed"));
    }

    #[test]
    fn must_hold_without_a_break() {
        let mut watch = watch(0.0, 0.3);
        assert_eq!(watch.look(0.1, &[9.0, 0.5]), None);
        assert_eq!(watch.look(0.2, &[9.0, 1.5]), None);
        assert_eq!(watch.look(0.3, &[9.0, 0.5]), None);
        assert_eq!(watch.look(0.5, &[9.0, 0.5]), None);
        assert!(watch.look(0.6, &[9.0, 0.5]).is_some());
    }
}
