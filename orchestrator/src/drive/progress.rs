//! What the user sees of a run in progress.

use super::{Course, Drive};
use crate::launch::Peer;
use crate::terminal::Progress;
use std::time::Instant;
use tremie_channels::Between;
use tremie_messages::Role;
use tremie_messages::start::Description;

/// The signal of grains that says how many bodies are there, where they come and go.
const BODIES: &str = "bodies";

impl<S: Between> Drive<'_, S> {
    /// Name of the signal that says how many bodies are there, where they come and go.
    pub(super) fn changing_bodies(&self) -> Option<String> {
        let counted = |(peer, description): (&Peer, &Description)| {
            let has = description.signals.iter().any(|signal| signal.name == BODIES);
            (peer.role == Role::Grains && has).then(|| format!("{}.{BODIES}", peer.name))
        };
        self.peers.iter().zip(self.descriptions).find_map(counted)
    }

    /// How many bodies there are: as the grains said last where they come and go, else as they said at first.
    fn bodies(&self) -> u64 {
        match self.changing_bodies() {
            Some(name) => self.table.newest(&name).unwrap_or(0.0) as u64,
            None => self.descriptions.iter().map(|description| description.bodies).sum(),
        }
    }

    /// Shows how far the run is, and how fast.
    pub(super) fn show_progress(&mut self, course: &Course, now: Instant) {
        let window = self.monitor.common_window().unwrap_or(0);
        let elapsed = now.duration_since(course.begin).as_secs_f64();
        let mut progress = Progress {
            window,
            windows: self.windows,
            time: self.clock.seconds(window * self.clock.ticks_per_window),
            rate: course.rate,
            work: Vec::new(),
            shares: Vec::new(),
            bodies: self.bodies(),
        };
        for (watched, peer) in self.physics.iter().enumerate() {
            let totals = self.monitor.totals()[watched];
            let name = &self.peers[*peer].name;
            // What was waited before the first window counts as well.
            let spent = (totals.compute + totals.wait + totals.exchange) as f64 * 1e-9;
            let share = |nanoseconds: u64| nanoseconds as f64 * 1e-9 / elapsed.max(spent).max(1e-9);
            progress.shares.push((name.clone(), share(totals.compute), share(totals.wait)));
            let unit = self.descriptions[*peer].work.clone();
            let rate = totals.work as f64 / (totals.compute as f64 * 1e-9).max(1e-9);
            progress.work.push((name.clone(), unit, rate));
        }
        self.terminal.progress(&progress);
    }
}
