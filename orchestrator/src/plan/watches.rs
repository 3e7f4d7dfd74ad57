//! Signals that a run watches, and the limits at which it stops.

use super::Described;
use crate::manifest::{Spec, WatchLimit};
use tremie_messages::finding::short;
use tremie_messages::{Limit, Role, WatchedQuantity, WatchedSignal};

/// A signal of a component that the run watches.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedWatch {
    /// Name of the component.
    pub component: String,
    /// Quantity that the signal is: its key in the manifest's table `watch`.
    pub quantity: WatchedQuantity,
    /// Limit as the component described it, with reason and remedy.
    pub limit: Limit,
    /// The signal with the levels that hold in this run.
    pub watched: WatchedSignal,
}

impl PlannedWatch {
    /// Full name of the signal.
    pub fn name(&self) -> String {
        format!("{}.{}", self.component, self.watched.signal)
    }

    /// The watch as a row of a table.
    pub(super) fn row(&self) -> Vec<String> {
        let WatchedSignal { from, limit, .. } = self.watched;
        vec![self.name(), short(from), short(limit), format!("watch.{}", self.quantity)]
    }
}

/// Heads of the table of watches.
pub(super) const HEADS: [&str; 4] = ["watched", "checkpoint above", "stop above", "set by"];

/// Signals that a run watches: those for which components gave a limit of a quantity, unless the
/// manifest says otherwise.
pub(super) fn watches(spec: &Spec, described: &[Described<'_>]) -> Vec<PlannedWatch> {
    let physics = described.iter().filter(|(component, _)| component.role != Role::Observer);
    let watch = |name: &str, limit: &Limit| {
        let quantity = limit.watch?;
        let stop = match spec.watch.get(&quantity) {
            Some(WatchLimit::Off) => None,
            Some(WatchLimit::Above(given)) => Some(*given),
            None => limit.wrong,
        };
        Some(PlannedWatch {
            component: name.to_string(),
            quantity,
            watched: WatchedSignal::under(&limit.signal, limit.doubtful, stop?),
            limit: limit.clone(),
        })
    };
    let of = |(component, description): &Described<'_>| {
        let is_told = |limit: &&Limit| description.signals.iter().any(|s| s.name == limit.signal);
        let limits = description.limits.iter().filter(is_told);
        limits.filter_map(|limit| watch(&component.name, limit)).collect::<Vec<_>>()
    };
    physics.flat_map(of).collect()
}

/// Watched signals of the component of a name.
pub(super) fn of(name: &str, watches: &[PlannedWatch]) -> Vec<WatchedSignal> {
    let own = watches.iter().filter(|watch| watch.component == name);
    own.map(|watch| watch.watched.clone()).collect()
}

/// Notes on limits of the manifest that nothing watches.
pub(super) fn notes(spec: &Spec, described: &[Described<'_>]) -> Vec<String> {
    let limits = described.iter().flat_map(|(_, description)| &description.limits);
    let is_known = |quantity| limits.clone().any(|limit| limit.watch == Some(quantity));
    let unused = spec.watch.keys().filter(|quantity| !is_known(**quantity));
    unused
        .map(|quantity| {
            format!("watch.{quantity} is not used: no component of this run has such a limit")
        })
        .collect()
}
