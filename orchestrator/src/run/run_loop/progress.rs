//! Progress of a run for the user: windows, rates, shares of wall time, bodies.

use super::{LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{ComponentTotals, LogLevel, OutputError, ScheduleTiming};
use crate::run::handshake::cores;
use crate::run::launch::Peer;
use crate::terminal::Progress;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::frame::{ComponentTiming, TimingHeader};
use tremie_messages::start::Description;
use tremie_messages::{Role, Stamp};

/// Wall time, and number of windows, after which the user sees the shares of a window's time.
const MEASURED: Duration = Duration::from_secs(5);
const FEW_WINDOWS: u64 = 100;

/// Least wall time between timings to observers: those of shorter spans are mostly noise.
const TIMINGS_APART: Duration = Duration::from_millis(50);

/// Signal of grains with the number of bodies, where bodies come and go.
const BODIES: &str = "bodies";

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Full name of the signal with the number of bodies, where bodies come and go.
    pub(super) fn changing_bodies(&self) -> Option<String> {
        let counted = |(peer, description): (&Peer, &Description)| {
            let has = description.signals.iter().any(|signal| signal.name == BODIES);
            (peer.role == Role::Grains && has).then(|| format!("{}.{BODIES}", peer.name))
        };
        self.peers.iter().zip(self.descriptions).find_map(counted)
    }

    /// Number of bodies: the newest signal where bodies come and go, else the number in the
    /// descriptions.
    fn bodies(&self) -> u64 {
        match self.changing_bodies() {
            Some(name) => self.table.newest(&name).unwrap_or(0.0) as u64,
            None => self.descriptions.iter().map(|description| description.bodies).sum(),
        }
    }

    /// Shares of a window's wall time, over the first `windows`.
    pub(super) fn turns(&self, windows: u64) -> Option<ScheduleTiming> {
        let worked = self.physics.iter().zip(self.monitor.totals());
        let worked =
            worked.map(|(&peer, &totals)| (self.peers[peer].role, self.threads[peer], totals));
        ScheduleTiming::of(self.schedule, cores(), worked, windows)
    }

    /// Shows the shares of a window's time once, after some windows.
    pub(super) fn show_timing(
        &mut self,
        state: &mut LoopState,
        now: Instant,
    ) -> Result<(), OutputError> {
        let begun = state.begun.is_some_and(|begun| now.duration_since(begun) > MEASURED);
        let window = self.monitor.common_window().unwrap_or(0);
        if state.shown_timing || !begun || window < FEW_WINDOWS {
            return Ok(());
        }
        state.shown_timing = true;
        let Some(turns) = self.turns(window) else { return Ok(()) };
        self.terminal.say(&turns.to_string());
        // Into the file only: measured times differ from run to run, and recordings of equal runs
        // must be equal.
        self.write_line(LogLevel::Info, ORCHESTRATOR, window, &turns.to_string())
    }

    /// Tells observers that ask for it what wall time the components have taken, if that is due; the last
    /// time is, whenever it comes.
    pub(super) fn send_timings(&mut self, state: &mut LoopState, now: Instant) {
        let (Some(window), Some(begun)) = (self.monitor.common_window(), state.begun) else {
            return;
        };
        let is_soon = |last: Instant| now.duration_since(last) < TIMINGS_APART;
        let is_due = !state.sent_timings.is_some_and(is_soon) && self.control.shows_timings(window);
        if !is_due && !state.is_over {
            return;
        }
        state.sent_timings = Some(now);
        let ticks = window * self.clock.ticks_per_window;
        let elapsed = (self.wall_before + now.duration_since(begun)).as_nanos() as u64;
        let header = TimingHeader { stamp: Stamp { window, ticks, ..Stamp::default() }, elapsed };
        let timing = |(watched, totals): (usize, &ComponentTotals)| ComponentTiming {
            windows: self.monitor.window_of(watched).unwrap_or(0),
            compute: totals.compute,
            wait: totals.wait,
            exchange: totals.exchange,
            work: totals.work,
        };
        let timings: Vec<_> = self.monitor.totals().iter().enumerate().map(timing).collect();
        self.control.show_timings(header, &timings);
    }

    /// Shows windows done, their rate, and shares of wall time.
    pub(super) fn show_progress(&mut self, state: &LoopState, now: Instant) {
        // This is asked after every look at the channels, some thousand times a second.
        if self.terminal.wants_progress() {
            let progress = self.current_progress(state, now);
            self.terminal.progress(&progress);
        }
    }

    /// Windows done, their rate, and shares of wall time.
    pub(super) fn current_progress(&self, state: &LoopState, now: Instant) -> Progress {
        let window = self.monitor.common_window().unwrap_or(0);
        let elapsed = now.duration_since(state.begin).as_secs_f64();
        let mut progress = Progress {
            window,
            windows: self.windows,
            time: self.clock.seconds(window * self.clock.ticks_per_window),
            rate: state.pace.rate(),
            work: Vec::new(),
            shares: Vec::new(),
            bodies: self.bodies(),
        };
        for (watched, peer) in self.physics.iter().enumerate() {
            let totals = self.monitor.totals()[watched];
            let name = &self.peers[*peer].name;
            // The wait before the first window counts as well: shares never exceed 1.
            let spent = (totals.compute + totals.wait + totals.exchange) as f64 * 1e-9;
            let share = |nanoseconds: u64| nanoseconds as f64 * 1e-9 / elapsed.max(spent).max(1e-9);
            progress.shares.push((name.clone(), share(totals.compute), share(totals.wait)));
            let unit = self.descriptions[*peer].work.clone();
            let rate = totals.work as f64 / (totals.compute as f64 * 1e-9).max(1e-9);
            progress.work.push((name.clone(), unit, rate));
        }
        progress
    }
}
