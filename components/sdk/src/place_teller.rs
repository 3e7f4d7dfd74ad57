//! Places of watched signals, told with the reports of windows in which a limit is passed.

use crate::role_adapter::RoleAdapter;
use tremie_channels::ChannelMedium;
use tremie_messages::start::{Assignment, Description};
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
    /// Of the signals of a component that its assignment watches; of none where it tells no places.
    pub fn new(description: &Description, assignment: &Assignment) -> Self {
        let watched = if description.tells_places { &assignment.watched[..] } else { &[] };
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
    /// that are above the first level for the first time. To find them takes time, and elsewhere
    /// nobody asks.
    pub fn push<S: ChannelMedium>(&mut self, player: &impl RoleAdapter<S>, values: &mut Vec<f64>) {
        for told in &mut self.told {
            let value = told.at.and_then(|at| values.get(at)).copied().unwrap_or(f64::NAN);
            let is_first = value > told.watched.from && !told.was_above;
            told.was_above |= is_first;
            let is_asked = is_first || value > told.watched.limit;
            let place = is_asked.then(|| player.place(&told.watched.signal)).flatten();
            values.extend(place.unwrap_or_default().values());
        }
    }
}
