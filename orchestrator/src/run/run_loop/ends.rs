//! Ends of a run: early and in order, by a condition or by the user; or at once, by a fault.

use super::{EndReason, LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{Ending, LogLevel, OutputError};
use std::sync::atomic::Ordering;
use std::time::Duration;
use tremie_channels::ChannelMedium;
use tremie_messages::control::Credit;

/// Windows between the one that meets a stop condition and the last one. The number is fixed, so
/// the last window does not depend on the speed at which the orchestrator looks.
pub(super) const STOP_AHEAD: u64 = 64;

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Ends in order at the user's first interrupt, at once at the second.
    pub(super) fn take_interrupts(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        let asked = self.interrupts.load(Ordering::Relaxed);
        let before = std::mem::replace(&mut state.asked, asked);
        match (asked, state.last) {
            (0, _) => Ok(()),
            (1, None) => {
                self.steering.release();
                if before == 0 {
                    let what = match self.can_begin_checkpoint(state) {
                        true => "with whole outputs and a checkpoint",
                        false => "with whole outputs",
                    };
                    self.terminal
                        .say(&format!("ending in order, {what}; once more to end at once"));
                }
                if self.checkpoints.under_way.is_some() && state.not_watching.is_empty() {
                    // Its window must be reached, and the next checkpoint is that of the end.
                    return Ok(());
                }
                // Not earlier: some components may have advanced through all that was granted.
                let mut last = state.granted.unwrap_or(self.first);
                if last > self.first && self.can_begin_checkpoint(state) {
                    self.begin_checkpoint(state, last + 1)?;
                    // A window after it: a run that goes on makes no end where this one does.
                    last += 2;
                }
                self.note(LogLevel::Info, ORCHESTRATOR, "the user asked for the end")?;
                self.ask_to_finish(state, last, Ending::Interrupted)
            }
            (1, Some(last)) => {
                if before == 0 {
                    let text = format!("already ending at window {last}; once more to end at once");
                    self.terminal.say(&text);
                }
                Ok(())
            }
            _ => Err(EndReason::Impatience),
        }
    }

    /// Makes `last` the last window of the run.
    pub(super) fn ask_to_finish(
        &mut self,
        state: &mut LoopState,
        last: u64,
        reason: Ending,
    ) -> Result<(), EndReason> {
        state.last = Some(last);
        state.granted = Some(last);
        state.reason = Some(reason);
        for peer in &self.physics {
            self.control.say(*peer, Credit::FINISH, last)?;
        }
        Ok(())
    }

    /// Ending of the run after the loop of windows; stops components that `reason` left running.
    pub(super) fn conclude(&mut self, state: &mut LoopState, reason: Option<EndReason>) -> Ending {
        let Some(reason) = reason else {
            return state.reason.take().unwrap_or(Ending::Completed);
        };
        self.stop_physics(state);
        match reason {
            EndReason::Impatience => Ending::Interrupted,
            EndReason::Fault(fault) => (*fault).into(),
            EndReason::Breach(breach) => (*breach).into(),
            EndReason::Output(error) => {
                let window = self.monitor.common_window().unwrap_or(0);
                error.into_fault(window).into()
            }
        }
    }

    /// Writes the log's last line, at the last window that all components completed.
    pub(super) fn log_ending(&mut self, ending: &Ending, window: u64) -> Result<(), OutputError> {
        match ending {
            Ending::Failed { fault, .. } => {
                self.note(LogLevel::Error, &fault.blamed, &fault.to_string())
            }
            Ending::Interrupted => Ok(()),
            Ending::Completed | Ending::Stopped { .. } => {
                let text = format!("the run is over at window {window}");
                self.note_at(window, LogLevel::Info, ORCHESTRATOR, &text)
            }
        }
    }

    /// Tells physics to end at once, and ends by force components that do not.
    fn stop_physics(&mut self, state: &LoopState) {
        for index in &self.physics {
            if !state.finished[*index] && !self.peers[*index].closed {
                // A broken channel changes nothing: the component is ended next.
                let _ = self.control.say(*index, Credit::ABORT, 0);
            }
        }
        for index in &self.physics {
            self.peers[*index].end(Duration::from_millis(50));
        }
    }
}
