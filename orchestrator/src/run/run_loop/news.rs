//! Replies, log lines and ends of components, as they arrive.

use super::{Course, Drive, Trouble};
use crate::run::launch::News;
use crate::run::monitor::Waiting;
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::start::{Fault, FaultKind, Reply};

/// Most arrivals that are handled in one look: a component that never stops talking must not keep
/// reports, deadlines and Ctrl-C waiting.
const BATCH: usize = 256;

impl<S: ChannelMedium> Drive<'_, S> {
    /// Handles arrivals since the last look, at most [`BATCH`]; sleeps up to `nap` if there are
    /// none.
    pub(super) fn hear_news(&mut self, course: &mut Course, nap: Duration) -> Result<(), Trouble> {
        let mut nap = nap;
        for _ in 0..BATCH {
            match self.news.recv_timeout(nap) {
                Ok((index, news)) => self.hear(course, index, news)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => break,
            }
            nap = Duration::ZERO;
        }
        Ok(())
    }

    fn hear(&mut self, course: &mut Course, index: usize, news: News) -> Result<(), Trouble> {
        let watched = self.physics.iter().position(|peer| *peer == index);
        match (news, watched) {
            (News::Reply(reply), Some(watched)) => {
                self.hear_physics(course, index, watched, *reply)
            }
            (News::Reply(reply), None) => self.hear_observer(course, index, *reply),
            (News::Garbage(text), Some(_)) => {
                Err(self.broken(index, format!("it wrote a line that is no reply: {text}")))
            }
            (News::Garbage(text) | News::Log(text), _) => Ok(self.hear_log(course, index, &text)?),
            (News::Closed, watched) => self.hear_end(course, index, watched),
        }
    }

    fn hear_physics(
        &mut self,
        course: &mut Course,
        index: usize,
        watched: usize,
        reply: Reply,
    ) -> Result<(), Trouble> {
        match reply {
            Reply::Waiting { from, what, owed, since, looked, window, turn } => {
                let wait = Waiting { from, what, owed, since, looked, window, turn };
                self.monitor.waiting(watched, wait);
            }
            Reply::Resumed {} => self.monitor.resumed(watched, Instant::now()),
            Reply::Finished { window, .. } => {
                // A component that ends early, in good order, would leave the others waiting.
                let last = course.last.unwrap_or(self.windows);
                if window != last {
                    let text = format!("it finished at window {window} of {last}");
                    return Err(self.broken(index, text));
                }
                course.finished[index] = true;
            }
            Reply::GaveUp { observer, why } => self.give_up(course, &observer, &why)?,
            Reply::Fault(fault) => return Err(fault.into()),
            other => return Err(self.broken(index, format!("it said {other:?} in mid-run"))),
        }
        Ok(())
    }

    fn hear_observer(
        &mut self,
        course: &mut Course,
        index: usize,
        reply: Reply,
    ) -> Result<(), Trouble> {
        match reply {
            Reply::Finished { note, .. } => {
                course.finished[index] = true;
                course.notes.insert(self.peers[index].name.clone(), note);
            }
            // A lost observer is a warning only. An output that cannot be written ends the run: the
            // run is made for it.
            Reply::Fault(fault) if fault.kind == FaultKind::Output => {
                course.finished[index] = true;
                course.not_watching.retain(|other| *other != index);
                let note = format!("not whole: {}", fault.message);
                course.notes.insert(self.peers[index].name.clone(), note);
                return Err(fault.into());
            }
            Reply::Fault(fault) => self.lose_observer(course, index, &fault.message)?,
            Reply::Busy {} => course.heard[index] = Instant::now(),
            Reply::Watching {} => course.not_watching.retain(|other| *other != index),
            _ => {}
        }
        Ok(())
    }

    /// Handles the closed line of a component: it has ended, in good order or not.
    fn hear_end(
        &mut self,
        course: &mut Course,
        index: usize,
        watched: Option<usize>,
    ) -> Result<(), Trouble> {
        self.peers[index].closed = true;
        // Reports that it sent before it ended count.
        self.take_reports()?;
        if course.finished[index] {
            return Ok(());
        }
        let how = self.peers[index].end(Duration::from_millis(100));
        let last = Some(&course.words[index]).filter(|text| !text.is_empty());
        let words = last.map_or(String::new(), |text| format!("; its last words: {text}"));
        let Some(watched) = watched else {
            return Ok(self.lose_observer(course, index, &format!("its process {how}{words}"))?);
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

    fn broken(&self, index: usize, message: String) -> Trouble {
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
