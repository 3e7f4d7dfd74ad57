//! Places of watched signals, told with the reports of windows in which a limit is passed.

use tremie_messages::start::Description;
use tremie_messages::{Place, WatchedSignal};

/// Tells the places of the signals that a run watches.
pub struct PlaceTeller {
    told: Vec<Told>,
}

struct Told {
    watched: WatchedSignal,
    /// Its place among the signals.
    at: Option<usize>,
    /// It has been above the first level.
    was_above: bool,
}

impl PlaceTeller {
    /// Of the signals of a component that the run watches; of none where it tells no places.
    pub fn of(description: &Description, watched: &[WatchedSignal]) -> Self {
        let watched = if description.tells_places { watched } else { &[] };
        let at = |name: &str| description.signals.iter().position(|signal| signal.name == name);
        let told = |watched: &WatchedSignal| Told {
            at: at(&watched.signal),
            watched: watched.clone(),
            was_above: false,
        };
        Self { told: watched.iter().map(told).collect() }
    }

    /// Values that it adds to a report.
    pub fn values(&self) -> usize {
        Place::VALUES * self.told.len()
    }

    /// Appends the places to the values of the signals: of those above their limits, and of those
    /// that are above the first level for the first time. `find` may take time, and is not asked
    /// elsewhere.
    pub fn push(&mut self, values: &mut Vec<f64>, find: impl Fn(&str) -> Option<Place>) {
        for told in &mut self.told {
            let value = told.at.and_then(|at| values.get(at)).copied().unwrap_or(f64::NAN);
            let is_first = value > told.watched.from && !told.was_above;
            told.was_above |= is_first;
            let is_asked = is_first || value > told.watched.limit;
            let place = is_asked.then(|| find(&told.watched.signal)).flatten();
            values.extend(place.unwrap_or_default().values());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use tremie_messages::start::Signal;

    #[test]
    fn a_place_is_sought_at_the_first_level_once_and_beyond_the_limit() {
        let signals = ["mass", "mach"].map(|name| Signal::new(name, "1", &[])).to_vec();
        let described = Description { signals, tells_places: true, ..Description::default() };
        let watched = ["mach", "gone"].map(|signal| WatchedSignal::under(signal, 1.0, 2.0));
        let mut teller = PlaceTeller::of(&described, &watched);
        assert_eq!(teller.values(), 10);
        let sought = Cell::new(0);
        let mut told = |mach: f64| {
            let mut values = vec![9.0, mach];
            teller.push(&mut values, |signal| {
                assert_eq!(signal, "mach");
                sought.set(sought.get() + 1);
                Some(Place::at([0.1, 0.2, 0.3]))
            });
            assert!(values[7..].iter().all(|x| x.is_nan()) && values.len() == 12);
            (Place::of_values(&values[2..7]).position.is_some(), sought.get())
        };
        let found = [0.5, 1.5, 0.5, 1.5, f64::NAN, 2.5, 2.5].map(&mut told);
        let places = [false, true, false, false, false, true, true];
        assert_eq!(found, std::array::from_fn(|k| (places[k], [0, 1, 1, 1, 1, 2, 3][k])));
        let silent = Description { tells_places: false, ..described };
        assert_eq!(PlaceTeller::of(&silent, &watched).values(), 0);
    }
}
