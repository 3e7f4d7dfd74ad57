//! One round of the loop of windows: arrivals, reports, rows, guards, credit.

use super::ends::STOP_AHEAD;
use super::{EndReason, LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{Ending, LogLevel, OutputError};
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::units;

/// Interval of the orchestrator's looks at reports. Physics does not wait for it: credit runs
/// ahead.
const LOOK: Duration = Duration::from_millis(1);

impl<S: ChannelMedium> RunLoop<'_, S> {
    pub(super) fn run_windows(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        let went = self.go_through_windows(state);
        went.map_err(|reason| self.first_reason(state, reason))
    }

    fn go_through_windows(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        loop {
            // Arrivals first: a component's word of a fault came before the silence that follows
            // it.
            self.take_events(state, LOOK)?;
            self.take_reports()?;
            self.take_rows(state)?;
            if let Some(breach) = state.breach.take() {
                return Err(EndReason::Breach(breach));
            }
            let now = Instant::now();
            // A finished component sent its reports before, so all of them are taken by now.
            if self.physics.iter().all(|index| state.finished[*index]) {
                return Ok(());
            }
            let deadline = self.silence_allowed();
            let lost = self.monitor.lost_message();
            let granted = state.granted.unwrap_or(0);
            if let Some(fault) = lost.or_else(|| self.monitor.silent(now, granted, deadline)) {
                return Err(fault.into());
            }
            self.lose_blind_observers(state, now)?;
            self.take_interrupts(state)?;
            self.take_commands(state)?;
            self.grant(state, now)?;
            self.show_timing(state, now)?;
            self.send_timings(state, now);
            self.show_progress(state, now);
        }
    }

    /// Longest time without a report of a component: where others wait for it, later than their own
    /// deadline, because a peer that waits names both sides.
    fn silence_allowed(&self) -> Duration {
        let is_alone = self.physics.len() == 1;
        units::wait(if is_alone { self.deadline } else { 1.2 * self.deadline + 0.1 })
    }

    pub(super) fn take_reports(&mut self) -> Result<(), EndReason> {
        let now = Instant::now();
        let (monitor, trace) = (&mut self.monitor, &mut self.trace);
        for (watched, peer) in self.physics.iter().enumerate() {
            self.control.reports(*peer, |report, signals| {
                monitor.report(watched, report, signals, now)?;
                let trace = trace.as_mut();
                Ok::<_, EndReason>(trace.map_or(Ok(()), |trace| trace.take(watched, report))?)
            })?;
        }
        Ok(())
    }

    fn take_rows(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        while let Some(row) = self.monitor.next_row() {
            self.heed_watchdogs(state, &row)?;
            let row = row.row;
            if state.breach.is_some() {
                // The last row that counts.
                self.table.take(row)?;
                return Ok(());
            }
            let (window, values) = (&row.window, &row.values);
            let time = self.clock.seconds(window * self.clock.ticks_per_window);
            // A later condition changes nothing: the last window is fixed once.
            if let Some(reason) = self.stop.look(time, values).filter(|_| state.last.is_none()) {
                let last = (window + STOP_AHEAD).min(self.windows);
                let text = format!("{reason}: the run ends at window {last}");
                self.note_at(*window, LogLevel::Info, ORCHESTRATOR, &text)?;
                self.ask_to_finish(state, last, Ending::Stopped { reason })?;
            }
            let window = row.window;
            self.table.take(row)?;
            self.keep_own_part(state, window)?;
        }
        Ok(())
    }

    /// Writes the rows that were whole when the end came.
    pub(super) fn take_last_rows(&mut self) -> Result<(), OutputError> {
        while let Some(row) = self.monitor.next_row() {
            self.table.take(row.row)?;
        }
        Ok(())
    }
}
