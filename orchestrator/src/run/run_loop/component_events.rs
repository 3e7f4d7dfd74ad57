//! Replies, log lines and ends of components, as they arrive.

use super::{EndReason, LoopState, RunLoop};
use crate::run::launch::ComponentEvent;
use crate::run::monitor::Waiting;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::start::{Fault, FaultKind, Reply};

/// Most arrivals that are handled in one look: a component that never stops talking must not keep
/// reports, deadlines and Ctrl-C waiting.
const BATCH: usize = 256;

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Handles arrivals since the last look, at most [`BATCH`]; sleeps up to `nap` if there are
    /// none.
    pub(super) fn take_events(
        &mut self,
        state: &mut LoopState,
        nap: Duration,
    ) -> Result<(), EndReason> {
        let mut nap = nap;
        for _ in 0..BATCH {
            match self.news.recv_timeout(nap) {
                Ok((index, news)) => self.hear(state, index, news)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => break,
            }
            nap = Duration::ZERO;
        }
        Ok(())
    }

    fn hear(
        &mut self,
        state: &mut LoopState,
        index: usize,
        news: ComponentEvent,
    ) -> Result<(), EndReason> {
        let watched = self.physics.iter().position(|peer| *peer == index);
        match (news, watched) {
            (ComponentEvent::Reply(reply), Some(watched)) => {
                self.take_reply(state, index, watched, *reply)
            }
            (ComponentEvent::Reply(reply), None) => self.take_observer_reply(state, index, *reply),
            (ComponentEvent::Garbage(text), Some(_)) => {
                Err(self.broken(index, format!("it wrote a line that is no reply: {text}")))
            }
            (ComponentEvent::Garbage(text) | ComponentEvent::Log(text), _) => {
                Ok(self.write_log(state, index, &text)?)
            }
            (ComponentEvent::Closed, watched) => self.take_end(state, index, watched),
        }
    }

    fn take_reply(
        &mut self,
        state: &mut LoopState,
        index: usize,
        watched: usize,
        reply: Reply,
    ) -> Result<(), EndReason> {
        match reply {
            Reply::Waiting { from, what, owed, since, looked, window, turn } => {
                let wait = Waiting { from, what, owed, since, looked, window, turn };
                self.monitor.waiting(watched, wait);
            }
            Reply::Resumed {} => self.monitor.resumed(watched, Instant::now()),
            Reply::Finished { window, .. } => {
                // A component that ends early, in good order, would leave the others waiting.
                let last = state.last.unwrap_or(self.windows);
                if window != last {
                    let text = format!("it finished at window {window} of {last}");
                    return Err(self.broken(index, text));
                }
                state.finished[index] = true;
            }
            Reply::Saved { window, bytes, copied } => {
                self.note_kept(index, window, [bytes, copied])?;
            }
            Reply::NotSaved { window, why } => self.note_not_kept(index, window, &why)?,
            Reply::GaveUp { observer, why } => self.give_up(state, &observer, &why)?,
            Reply::Ranks { window, begin, ranks } => {
                state.ranks.entry(index).or_default().take(&ranks);
                if let Some(trace) = &mut self.trace {
                    trace.take_ranks(watched, window, begin, &ranks)?;
                }
            }
            Reply::Fault(fault) => return Err(fault.into()),
            other => return Err(self.broken(index, format!("it said {other:?} in mid-run"))),
        }
        Ok(())
    }

    fn take_observer_reply(
        &mut self,
        state: &mut LoopState,
        index: usize,
        reply: Reply,
    ) -> Result<(), EndReason> {
        match reply {
            Reply::Finished { note, .. } => {
                state.finished[index] = true;
                state.notes.insert(self.peers[index].name.clone(), note);
            }
            // A lost observer is a warning only. An output that cannot be written ends the run: the
            // run is made for it.
            Reply::Fault(fault) if fault.kind == FaultKind::Output => {
                state.finished[index] = true;
                state.not_watching.retain(|other| *other != index);
                let note = format!("not whole: {}", fault.message);
                state.notes.insert(self.peers[index].name.clone(), note);
                return Err(fault.into());
            }
            Reply::Fault(fault) => self.lose_observer(state, index, &fault.message)?,
            Reply::Busy {} => state.heard[index] = Instant::now(),
            Reply::Saved { window, bytes, copied } => {
                state.heard[index] = Instant::now();
                self.note_kept(index, window, [bytes, copied])?;
            }
            Reply::NotSaved { window, why } => self.note_not_kept(index, window, &why)?,
            Reply::Watching {} => state.not_watching.retain(|other| *other != index),
            _ => {}
        }
        Ok(())
    }

    /// Handles the closed line of a component: it has ended, in good order or not.
    fn take_end(
        &mut self,
        state: &mut LoopState,
        index: usize,
        watched: Option<usize>,
    ) -> Result<(), EndReason> {
        self.peers[index].closed = true;
        // Reports that it sent before it ended count.
        self.take_reports()?;
        if state.finished[index] {
            return Ok(());
        }
        let how = self.peers[index].end(Duration::from_millis(100));
        let last = state.words[index].text();
        let words = last.map_or(String::new(), |text| format!("; its last words: {text}"));
        let Some(watched) = watched else {
            return Ok(self.lose_observer(state, index, &format!("its process {how}{words}"))?);
        };
        let fault = Fault {
            kind: FaultKind::Exit,
            noticed_by: "the orchestrator".into(),
            blamed: self.peers[index].name.clone(),
            window: self.monitor.window_of(watched).map_or(0, |w| w + 1),
            message: format!("its process {how} in mid-run{words}"),
        };
        Err(fault.into())
    }

    fn broken(&self, index: usize, message: String) -> EndReason {
        let fault = Fault {
            kind: FaultKind::Contract,
            noticed_by: "the orchestrator".into(),
            blamed: self.peers[index].name.clone(),
            window: self.monitor.common_window().unwrap_or(0),
            message,
        };
        fault.into()
    }
}
