//! Watchdogs: signals that tell whether the physics goes wrong, and stop the run if it does.
//!
//! They are pure: rows of signals go in, and what is to be done comes out. A row depends on the
//! physics alone, so a run stops at the same window however many threads and processes it has, and
//! whoever looks.

use crate::outputs::{Breach, with_unit};
use crate::plan::PlannedWatch;
use std::collections::BTreeMap;
use tremie_messages::start::Signal;
use tremie_messages::{Place, WatchedSignal};
use tremie_state::{KeepsState, StateError, StateExchange};

/// Fewest windows from a checkpoint that a watchdog asked for to the next.
const LEAST_APART: u64 = 100;
/// The next comes when the run has this part of its windows more, at the earliest: so a value that
/// swings about its level asks a number of times that grows as the logarithm of the run's length.
const PART_MORE: u64 = 2;
/// Part of the first level from which on components get little leave ahead, so that a checkpoint
/// which is asked for comes soon.
const WARY: f64 = 0.25;

/// The watchdogs of a run.
#[derive(Debug, Default)]
pub struct Watchdogs {
    dogs: Vec<Watchdog>,
    /// First window whose row may ask for a checkpoint.
    next_checkpoint: u64,
}

/// One signal that is watched.
#[derive(Debug)]
struct Watchdog {
    watch: PlannedWatch,
    unit: String,
    /// Index of its signal in a row.
    at: usize,
    /// Index of its place in the places of a row; `None` where its component tells none.
    place: Option<usize>,
    /// The last value that was measured.
    newest: f64,
    /// It was above the first level.
    was_above: bool,
    /// It has been said that it was.
    is_said: bool,
}

/// What watchdogs make of a row.
#[derive(Debug, Default, PartialEq)]
pub struct Alarm {
    /// Sentences on signals that came above their first levels, each once in a run.
    pub sentences: Vec<String>,
    /// A checkpoint shall be made, for the signal of this name.
    pub checkpoint: Option<String>,
    /// The run shall stop.
    pub breach: Option<Breach>,
}

impl Watchdogs {
    /// Watches `watches`; `signals` gives the full names of a row's values, `places` how many values
    /// of places each component reports, in the order of a row.
    pub fn new(
        watches: &[PlannedWatch],
        signals: &[(String, Signal)],
        places: &[(String, usize)],
    ) -> Self {
        let dog = |watch: &PlannedWatch| {
            let name = watch.name();
            let at = signals.iter().position(|(known, _)| *known == name)?;
            let own = watches.iter().filter(|other| other.component == watch.component);
            let rank =
                own.clone().position(|other| other.watched.signal == watch.watched.signal)?;
            let before = places.iter().take_while(|(component, _)| *component != watch.component);
            let offset = before.map(|(_, values)| values).sum::<usize>() + rank * Place::VALUES;
            let tells = places.iter().any(|(name, n)| *name == watch.component && *n > 0);
            Some(Watchdog {
                unit: signals[at].1.unit.clone(),
                watch: watch.clone(),
                at,
                place: tells.then_some(offset),
                newest: f64::NAN,
                was_above: false,
                is_said: false,
            })
        };
        Self { dogs: watches.iter().filter_map(dog).collect(), next_checkpoint: 0 }
    }

    /// True if nothing is watched.
    pub fn is_idle(&self) -> bool {
        self.dogs.is_empty()
    }

    /// True if a signal is so near its first level that a checkpoint may be asked for soon.
    pub fn is_wary(&self) -> bool {
        self.dogs.iter().any(|dog| dog.newest > WARY * dog.watch.watched.from)
    }

    /// Looks at the row of a window, and at its places.
    pub fn look(&mut self, window: u64, values: &[f64], places: &[f64]) -> Alarm {
        let mut alarm = Alarm::default();
        for dog in &mut self.dogs {
            let value = values.get(dog.at).copied().unwrap_or(f64::NAN);
            if value.is_nan() {
                // Not measured in this window, or not reported.
                continue;
            }
            dog.newest = value;
            let is_above = value > dog.watch.watched.from;
            let was_above = std::mem::replace(&mut dog.was_above, is_above);
            let has_come = is_above && !was_above;
            if value > dog.watch.watched.limit {
                let breach = || dog.breach(window, value, places);
                alarm.breach = alarm.breach.or_else(|| Some(breach()));
            } else if has_come {
                if !std::mem::replace(&mut dog.is_said, true) {
                    alarm.sentences.push(dog.sentence(window, value, places));
                }
                alarm.checkpoint = alarm.checkpoint.or_else(|| Some(dog.watch.name()));
            }
        }
        if alarm.breach.is_some() || window < self.next_checkpoint {
            alarm.checkpoint = None;
        }
        if alarm.checkpoint.is_some() {
            self.next_checkpoint = window + LEAST_APART.max(window / PART_MORE);
        }
        alarm
    }
}

impl KeepsState for Watchdogs {
    const STATE_VERSION: u32 = 1;

    /// Keeps which signals were above their first levels, or puts it back.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let told = self.dogs.iter().map(|dog| (dog.watch.name(), (dog.was_above, dog.is_said)));
        let mut told: BTreeMap<String, (bool, bool)> = told.collect();
        state.value("told", &mut told)?;
        for dog in &mut self.dogs {
            (dog.was_above, dog.is_said) = told.get(&dog.watch.name()).copied().unwrap_or_default();
        }
        state.value("next_checkpoint", &mut self.next_checkpoint)
    }
}

impl Watchdog {
    fn place(&self, places: &[f64]) -> Place {
        let values = self.place.and_then(|at| places.get(at..at + Place::VALUES));
        Place::of_values(values.unwrap_or_default())
    }

    fn breach(&self, window: u64, value: f64, places: &[f64]) -> Breach {
        let PlannedWatch { component, quantity, limit, watched } = &self.watch;
        Breach {
            component: component.clone(),
            signal: self.watch.name(),
            quantity: *quantity,
            what: limit.quantity.clone(),
            value,
            unit: self.unit.clone(),
            limit: watched.limit,
            window,
            place: self.place(places),
            advice: [limit.why.clone(), limit.remedy.clone()],
            checkpoint: None,
        }
    }

    fn sentence(&self, window: u64, value: f64, places: &[f64]) -> String {
        let PlannedWatch { component, quantity, limit, watched } = &self.watch;
        let WatchedSignal { from, limit: stop, .. } = watched;
        let [value, from, stop] = [value, *from, *stop].map(|value| with_unit(value, &self.unit));
        let (what, place) = (&limit.quantity, self.place(places));
        format!(
            "{component}: {what}{place} is {value} at window {window}, above {from}; the run stops above {stop} (watch.{quantity})"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::{Limit, WatchedQuantity};

    fn watch(component: &str, signal: &str, from: f64, limit: f64) -> PlannedWatch {
        PlannedWatch {
            component: component.into(),
            quantity: WatchedQuantity::Mach,
            limit: Limit {
                signal: signal.into(),
                quantity: format!("greatest {signal}"),
                unit: "1".into(),
                doubtful: from,
                wrong: Some(limit),
                why: String::new(),
                remedy: String::new(),
                watch: Some(WatchedQuantity::Mach),
            },
            watched: WatchedSignal { signal: signal.into(), from, limit },
        }
    }

    /// Two signals of a fluid that tells places, one of grains that do not.
    fn watchdogs() -> Watchdogs {
        let watches = [
            watch("fluid", "mach", 0.1, 0.2),
            watch("fluid", "density", 0.1, 0.3),
            watch("grains", "overlap", 0.1, 0.5),
        ];
        let names = ["fluid.mass", "fluid.mach", "fluid.density", "grains.overlap"];
        let signals = names.map(|name| (name.to_string(), Signal::new(name, "1", &[])));
        let places = [("fluid".into(), 2 * Place::VALUES), ("grains".into(), 0)];
        Watchdogs::new(&watches, &signals, &places)
    }

    const NOWHERE: [f64; 10] = [f64::NAN; 10];

    #[test]
    fn the_first_level_asks_for_a_checkpoint_and_the_limit_stops_the_run() {
        let mut dogs = watchdogs();
        assert_eq!(dogs.look(1, &[9.0, 0.02, 0.0, 0.0], &NOWHERE), Alarm::default());
        assert!(!dogs.is_wary());
        assert_eq!(dogs.look(2, &[9.0, 0.03, 0.0, 0.0], &NOWHERE), Alarm::default());
        assert!(dogs.is_wary());
        let alarm = dogs.look(3, &[9.0, 0.11, 0.0, 0.0], &NOWHERE);
        assert_eq!(alarm.checkpoint.as_deref(), Some("fluid.mach"));
        assert!(alarm.sentences[0].contains("greatest mach is 0.11 at window 3"), "{alarm:?}");
        let mut places = NOWHERE;
        places[5..8].copy_from_slice(&[1.0, 2.0, 3.0]);
        let alarm = dogs.look(4, &[9.0, 0.15, 0.31, 0.6], &places);
        let breach = alarm.breach.unwrap();
        assert_eq!((breach.signal.as_str(), breach.window), ("fluid.density", 4));
        assert_eq!(breach.place, Place::at([1.0, 2.0, 3.0]));
        assert_eq!((alarm.checkpoint, breach.value), (None, 0.31));
        let alarm = dogs.look(5, &[9.0, 0.1, 0.1, 0.6], &places);
        assert!(alarm.breach.unwrap().place.is_unknown(), "grains tell no place");
    }

    #[test]
    fn a_value_that_swings_asks_seldom_and_is_said_once() {
        let mut dogs = watchdogs();
        let (mut asked, mut said) = (Vec::new(), 0);
        for window in 1..=100_000 {
            let value = if window % 2 == 0 { 0.11 } else { 0.09 };
            let alarm = dogs.look(window, &[0.0, value, 0.0, 0.0], &NOWHERE);
            asked.extend(alarm.checkpoint.map(|_| window));
            said += alarm.sentences.len();
        }
        assert_eq!((asked[..4].to_vec(), said), (vec![2, 102, 202, 304], 1));
        assert!(asked.len() < 20, "{asked:?}");
    }

    #[test]
    fn a_value_that_stays_above_asks_once_and_what_is_not_measured_asks_never() {
        let mut dogs = watchdogs();
        let mut asked = 0;
        for window in 1..10_000 {
            let value = if window % 3 == 0 { f64::NAN } else { 0.15 };
            let alarm = dogs.look(window, &[0.0, value, 0.0, 0.0], &NOWHERE);
            asked += usize::from(alarm.checkpoint.is_some());
            assert_eq!(alarm.breach, None);
        }
        assert_eq!(asked, 1);
    }

    #[test]
    fn what_was_said_is_kept() {
        let mut before = watchdogs();
        before.look(7, &[0.0, 0.11, 0.0, 0.0], &NOWHERE);
        let kept = tremie_state::SavedState::of(&mut before).unwrap();
        let mut after = watchdogs();
        kept.restore(&mut after).unwrap();
        assert_eq!(after.look(8, &[0.0, 0.12, 0.0, 0.0], &NOWHERE), Alarm::default());
    }
}
