//! Watchdogs in the loop of windows: a checkpoint while a signal is on its way to its limit, and an
//! end in order when it has passed it.

use super::{EndReason, LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{Breach, LogLevel, OutputError};
use crate::run::monitor::WatchedRow;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::start::{Fault, FaultKind};
use tremie_messages::units;

/// Interval of looks at the replies of components that still write their states.
const LOOK: Duration = Duration::from_millis(1);

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Lets the watchdogs look at a row.
    pub(super) fn heed_watchdogs(
        &mut self,
        state: &mut LoopState,
        WatchedRow { row, places }: &WatchedRow,
    ) -> Result<(), OutputError> {
        let alarm = self.watchdogs.look(row.window, &row.values, places);
        for sentence in &alarm.sentences {
            self.terminal.say(sentence);
            self.note_at(row.window, LogLevel::Warning, ORCHESTRATOR, sentence)?;
        }
        if let Some(signal) = alarm.checkpoint {
            self.checkpoints.ask(signal, row.window);
        }
        state.breach = state.breach.take().or(alarm.breach.map(Box::new));
        Ok(())
    }

    /// What ended the loop. The physics may have gone wrong before a fault that it made: then that is
    /// the reason. Waits for a checkpoint from before the breach that is still being written.
    pub(super) fn first_reason(&mut self, state: &mut LoopState, reason: EndReason) -> EndReason {
        let breach = match reason {
            EndReason::Breach(breach) => breach,
            EndReason::Fault(fault) if fault.kind != FaultKind::Output => {
                match self.breach_before(state, &fault) {
                    Some(breach) => breach,
                    None => return EndReason::Fault(fault),
                }
            }
            other => return other,
        };
        self.await_checkpoint(state, breach.window);
        EndReason::Breach(Box::new(Breach { checkpoint: self.checkpoints.newest, ..*breach }))
    }

    /// A breach in windows before that of a fault, whose rows were not looked at yet.
    fn breach_before(&mut self, state: &mut LoopState, fault: &Fault) -> Option<Box<Breach>> {
        if self.watchdogs.is_idle() {
            return None;
        }
        // What fails here fails because of the fault.
        let _ = self.take_reports();
        while state.breach.is_none()
            && let Some(row) = self.monitor.next_row()
        {
            let _ = self.heed_watchdogs(state, &row);
            let window = row.row.window;
            let _ = self.table.take(row.row);
            if state.breach.is_none() {
                let _ = self.keep_own_part(state, window);
            }
        }
        // A component that waits for the one that failed may owe its part of the last rows.
        let late: Vec<WatchedRow> = self.monitor.rows_under_way().cloned().collect();
        for row in &late {
            if state.breach.is_none() {
                let _ = self.heed_watchdogs(state, row);
            }
        }
        state.breach.take().filter(|breach| breach.window <= fault.window)
    }

    /// Waits until a checkpoint of a window before `window` is whole, if one is under way.
    fn await_checkpoint(&mut self, state: &mut LoopState, window: u64) {
        let (begin, most) = (Instant::now(), units::wait(self.deadline));
        while self.is_being_written(window)
            && begin.elapsed() < most
            && self.interrupts.load(Ordering::Relaxed) < 2
        {
            // Other faults follow from the breach, or do not matter any more.
            if let Err(EndReason::Output(_)) = self.take_events(state, LOOK) {
                return;
            }
        }
    }
}
