//! Commands of a user to the run in progress.
//!
//! A run that is held gets no credit beyond a window. A change of the manifest takes a checkpoint, ends
//! the run in order, and is left to the caller, who goes on from the checkpoint with the changed manifest.

use super::checkpoints::UnderWay;
use super::{EndReason, LoopState, RunLoop};
use crate::manifest::ORCHESTRATOR;
use crate::outputs::{ChangeRecord, Ending, LogLevel, MANIFEST, OutputError};
use crate::run::changes;
use crate::steering::{
    Answer, RunState, RunStatus, SteeringCommand, SteeringRequest, SteeringSocket,
};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;
use tremie_channels::ChannelMedium;

/// A change that a user made to a run in progress.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What changes, and the window from whose end on it holds; there is a checkpoint of it.
    pub record: ChangeRecord,
    /// The run was paused, and shall be again.
    pub is_paused: bool,
}

/// What users want of a run in progress.
pub struct Steering {
    socket: Option<SteeringSocket>,
    run: String,
    manifest: PathBuf,
    /// Last window that may be made while the run is held.
    hold: Option<u64>,
    /// Commands that are answered when their window is made.
    until_window: Vec<(u64, SteeringRequest)>,
    /// Commands that are answered when the checkpoint of their window is whole.
    until_checkpoint: Vec<(u64, SteeringRequest)>,
    /// Commands that need a checkpoint, while another is under way.
    queue: VecDeque<SteeringRequest>,
    /// Changes that were planned before the run, in the order of their windows.
    planned: VecDeque<ChangeRecord>,
    /// A change whose checkpoint is under way.
    change: Option<Change>,
    /// A change for which the run ends.
    pub(super) taken: Option<Change>,
}

impl Steering {
    /// Listens on a socket, if there is one; the run is held at the end of window `pause_at`.
    pub fn new(
        socket: Option<SteeringSocket>,
        run: u64,
        manifest: PathBuf,
        pause_at: Option<u64>,
        planned: VecDeque<ChangeRecord>,
    ) -> Self {
        Self {
            socket,
            run: format!("{run:016x}"),
            manifest,
            hold: pause_at,
            until_window: Vec::new(),
            until_checkpoint: Vec::new(),
            queue: VecDeque::new(),
            planned,
            change: None,
            taken: None,
        }
    }

    /// Last window that may be granted.
    pub(super) fn last_window(&self) -> u64 {
        let before = self.planned.front().map_or(u64::MAX, |change| change.window - 1);
        self.hold.unwrap_or(u64::MAX).min(before)
    }

    /// The run ends: nothing holds it any longer, and no change is made.
    pub(super) fn release(&mut self) {
        self.hold = None;
        self.change = None;
        self.planned.clear();
        let waiting = self.until_window.drain(..).map(|(_, asked)| asked);
        waiting.chain(self.queue.drain(..)).for_each(|asked| asked.refuse("the run is ending"));
    }

    fn next(&self) -> Option<SteeringRequest> {
        self.socket.as_ref()?.next()
    }

    /// The planned change that is due, if the next window to grant is `next`.
    fn due(&mut self, next: u64) -> Option<SteeringRequest> {
        let planned = self.planned.pop_front_if(|change| change.window == next)?;
        Some(SteeringRequest::planned(SteeringCommand::Set { changes: planned.set }))
    }
}

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Obeys commands that have come, and answers those that are done.
    pub(super) fn take_commands(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        while let Some(asked) = self.steering.next() {
            self.obey(state, asked)?;
        }
        if self.checkpoints.under_way.is_none() {
            self.answer_after_checkpoint(state)?;
            let next = state.granted.map_or(0, |granted| granted + 1);
            if let Some(planned) = self.steering.due(next) {
                self.obey(state, planned)?;
            }
            if let Some(asked) = self.steering.queue.pop_front() {
                self.obey(state, asked)?;
            }
        }
        self.answer_at_window();
        Ok(())
    }

    fn obey(&mut self, state: &mut LoopState, asked: SteeringRequest) -> Result<(), EndReason> {
        let command = asked.command.clone();
        if let SteeringCommand::Status {} = command {
            let status = self.status(state);
            asked.answer(Answer::Status(Box::new(status)));
            return Ok(());
        }
        if let Some(last) = state.last {
            asked.refuse(format!("the run is ending already, at window {last}"));
            return Ok(());
        }
        // The window of a checkpoint under way must be made: nothing that waits for it would end.
        let begun = self.checkpoints.under_way.as_ref().map_or(0, UnderWay::window);
        let granted = state.granted.unwrap_or(self.first).max(begun);
        match command {
            SteeringCommand::Status {} => {}
            SteeringCommand::Pause {} => {
                self.record("pause", granted)?;
                self.hold_at(granted, asked);
            }
            SteeringCommand::Step { windows } => {
                let last = self.steering.hold.unwrap_or(granted).saturating_add(windows);
                self.record(&format!("step of {windows} windows"), last)?;
                self.hold_at(last, asked);
            }
            SteeringCommand::Continue {} if self.steering.change.is_some() => {
                asked.refuse("a change is being made; the run goes on by itself after it");
            }
            SteeringCommand::Continue {} => {
                self.record("continue", granted)?;
                self.steering.hold = None;
                let text = format!("goes on after window {granted}");
                asked.answer(Answer::Done { text, window: granted });
            }
            SteeringCommand::Stop {} => {
                self.record("stop", granted)?;
                self.interrupts.fetch_add(1, Ordering::Relaxed);
                let text = format!("ends in order, soon after window {granted}");
                asked.answer(Answer::Done { text, window: granted });
            }
            SteeringCommand::Checkpoint {} | SteeringCommand::Set { .. } => {
                self.ask_for_checkpoint(state, asked)?;
            }
        }
        Ok(())
    }

    fn hold_at(&mut self, window: u64, asked: SteeringRequest) {
        self.steering.hold = Some(window);
        self.steering.until_window.push((window, asked));
    }

    /// Begins a checkpoint for a command, or queues the command while another is under way.
    fn ask_for_checkpoint(
        &mut self,
        state: &mut LoopState,
        asked: SteeringRequest,
    ) -> Result<(), OutputError> {
        if self.checkpoints.under_way.is_some() || !state.not_watching.is_empty() {
            self.steering.queue.push_back(asked);
            return Ok(());
        }
        if let Some(why) = self.why_no_checkpoint(state) {
            self.refuse(asked, why);
            return Ok(());
        }
        let window = state.granted.unwrap_or(self.first) + 1;
        let held = self.steering.hold;
        if let SteeringCommand::Set { changes: sets } = &asked.command {
            let sets = sets.clone();
            let file = self.checkpoints.output.join(MANIFEST);
            if let Err(error) = changes::changed(&file, &self.checkpoints.manifest, &sets) {
                self.refuse(asked, error.to_string());
                return Ok(());
            }
            let record = ChangeRecord { window, set: sets };
            self.steering.change = Some(Change { record, is_paused: held.is_some() });
        }
        self.begin_checkpoint(state, window)?;
        // Its window must be made, also by a run that is paused. What would come after a change would be
        // made again.
        if held.is_some() || self.steering.change.is_some() {
            self.steering.hold = Some(held.unwrap_or(0).max(window));
        }
        self.steering.until_checkpoint.push((window, asked));
        Ok(())
    }

    /// Refuses a command; a planned one has no user who would hear of it.
    fn refuse(&self, asked: SteeringRequest, why: String) {
        if asked.is_planned() {
            self.terminal.warn(&format!("a planned change was not made: {why}"));
        }
        asked.refuse(why);
    }

    /// Why no checkpoint can begin now; `None` if one can.
    fn why_no_checkpoint(&self, state: &LoopState) -> Option<String> {
        if self.can_begin_checkpoint(state) {
            return None;
        }
        if self.checkpoints.when.keep == 0 {
            return Some("this run keeps no checkpoints: run.checkpoints.keep is 0".into());
        }
        let without = (self.physics.iter())
            .filter(|index| self.descriptions[**index].state.is_none())
            .map(|index| self.peers[*index].name.as_str());
        let without: Vec<_> = without.collect();
        if !without.is_empty() {
            let names = without.join(", ");
            return Some(format!("this run cannot be kept: {names} keeps no state"));
        }
        Some("the run is about to end: no window is left for a checkpoint".into())
    }

    /// Answers commands whose checkpoint is no longer under way.
    fn answer_after_checkpoint(&mut self, state: &mut LoopState) -> Result<(), EndReason> {
        for (window, asked) in std::mem::take(&mut self.steering.until_checkpoint) {
            let change = self.steering.change.take_if(|change| change.record.window == window);
            if self.checkpoints.newest != Some(window) {
                if let Some(change) = change {
                    self.steering.hold = change.is_paused.then_some(window);
                }
                let why = "could not be made; the run's log says why";
                self.refuse(asked, format!("the checkpoint of window {window} {why}"));
                continue;
            }
            let Some(change) = change else {
                self.record("checkpoint", window)?;
                let text = format!("checkpoint of window {window}");
                asked.answer(Answer::Done { text, window });
                continue;
            };
            let sets = change.record.set.iter().map(|(key, value)| format!("{key}={value}"));
            let text = format!("{} from window {window} on", sets.collect::<Vec<_>>().join(", "));
            self.record(&format!("set {text}"), window)?;
            asked.answer(Answer::Done { text, window });
            // The window after it is made twice: a run that goes on makes no end where this one does.
            self.ask_to_finish(state, window + 1, Ending::Interrupted)?;
            self.steering.taken = Some(change);
        }
        Ok(())
    }

    /// Answers commands whose window all components have made.
    fn answer_at_window(&mut self) {
        if self.steering.until_window.is_empty() {
            return;
        }
        let Some(done) = self.monitor.common_window() else { return };
        let waiting = std::mem::take(&mut self.steering.until_window);
        let (reached, open): (Vec<_>, Vec<_>) =
            waiting.into_iter().partition(|(window, _)| *window <= done);
        self.steering.until_window = open;
        for (window, asked) in reached {
            let text = format!("stands after window {window}");
            self.terminal.say(&format!("{text}; `tremie continue` goes on"));
            asked.answer(Answer::Done { text, window });
        }
    }

    /// Writes a command into the log: into the file only, because recordings of equal runs must be equal.
    fn record(&mut self, what: &str, window: u64) -> Result<(), OutputError> {
        self.write_line(LogLevel::Info, ORCHESTRATOR, window, &format!("steered: {what}"))
    }

    fn status(&self, state: &LoopState) -> RunStatus {
        let run_state = match (state.last, self.steering.hold) {
            (Some(_), _) => RunState::Ending,
            (None, _) if state.begun.is_none() && self.first == 0 => RunState::Starting,
            (None, Some(_)) => RunState::Paused,
            (None, None) => RunState::Running,
        };
        let out = &self.checkpoints.output;
        RunStatus {
            run: self.steering.run.clone(),
            state: run_state,
            out: std::path::absolute(out).unwrap_or_else(|_| out.clone()),
            manifest: self.steering.manifest.clone(),
            process: std::process::id(),
            checkpoint: self.checkpoints.newest,
            progress: self.current_progress(state, Instant::now()),
        }
    }
}
