//! Credit: windows through which components may advance. It runs ahead of the completed windows, so
//! that physics never waits for the orchestrator.

use super::ends::STOP_AHEAD;
use super::{EndReason, LoopState, RunLoop};
use crate::outputs::Ending;
use std::time::Instant;
use tremie_channels::ChannelMedium;
use tremie_messages::control::Credit;

/// Wall time by which credit runs ahead [s]: the delay of a Ctrl-C.
const CREDIT_AHEAD: f64 = 0.1;

/// The same where a signal is near the level at which a watchdog asks for a checkpoint, which shall
/// come soon then [s]. Some looks of the orchestrator.
const WARY_AHEAD: f64 = 0.005;
/// Most windows ahead where anything is watched: signals come near their levels in fewer.
const WATCHED_MOST: u64 = 256;

/// Windows between the one whose row asks for a checkpoint and that of the checkpoint, if no
/// component had leave to go further. Where windows take a third of a millisecond or longer, that
/// depends on the physics alone.
pub(super) const ASKED_AHEAD: u64 = 16;

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Lets components advance some windows beyond the last that all have completed.
    pub(super) fn grant(&mut self, state: &mut LoopState, now: Instant) -> Result<(), EndReason> {
        if state.last.is_some() {
            return Ok(());
        }
        if state.not_watching.is_empty()
            && let Some((last, reason)) = state.resumed_end.take()
        {
            return self.ask_to_finish(state, last, Ending::Stopped { reason });
        }
        self.look_after_checkpoints(state, now)?;
        let done = self.monitor.common_window().map_or(0, |window| window + 1);
        state.pace.note(done, now);
        // A condition ends the run STOP_AHEAD windows later. Credit stays below that window: a
        // component that advances through it must know that it is the last.
        let most = if self.stop.is_idle() { self.report_depth / 2 } else { STOP_AHEAD - 1 };
        let most = if self.watchdogs.is_idle() { most } else { most.min(WATCHED_MOST) };
        if !state.not_watching.is_empty() {
            // Only the start exchange, or what stands for it where the run goes on, until lossless observers have taken their first frames.
            return self.grant_through(state, self.first);
        }
        let (time, least) = match self.watchdogs.is_wary() {
            true => (WARY_AHEAD, ASKED_AHEAD - 1),
            // Never less than 4 windows: physics must not wait for the next look.
            false => (CREDIT_AHEAD, 4),
        };
        let ahead = ((state.pace.rate() * time) as u64).clamp(least.min(most), most);
        let most =
            self.windows.min(self.last_before_checkpoint(state)).min(self.steering.last_window());
        self.grant_through(state, (done + ahead).min(most))
    }

    fn grant_through(&mut self, state: &mut LoopState, grant: u64) -> Result<(), EndReason> {
        if state.granted.is_some_and(|granted| granted >= grant) {
            return Ok(());
        }
        // Components without credit were silent rightly: their deadlines begin anew.
        if state.granted.is_none_or(|granted| self.monitor.all_wait_for_credit(granted)) {
            self.monitor.granted(Instant::now());
        }
        state.granted = Some(grant);
        for peer in &self.physics {
            self.control.say(*peer, Credit::ADVANCE, grant)?;
        }
        Ok(())
    }
}
