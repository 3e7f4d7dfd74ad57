//! Observers in the loop of windows: they never stop the physics, and are waited for a bounded
//! time.

use super::{EndReason, LoopState, RunLoop};
use crate::outputs::{LogLevel, OutputError};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::control::Credit;
use tremie_messages::start::FaultKind;
use tremie_messages::units;

/// Longest time for a lossless observer to take the frames of the start exchange.
const FIRST_FRAMES: Duration = Duration::from_secs(10);
/// Longest time without a word of an observer, once all is sent; then it has hung.
const SILENCE: Duration = Duration::from_secs(5);
/// Longest time for an observer to close its files, once all is sent: the record of a long run is worth more than
/// the seconds for which a shared disk stands still.
const CLOSING: Duration = Duration::from_secs(60);

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Gives an observer up that failed: a warning, and nothing waits for it any longer.
    pub(super) fn lose_observer(
        &mut self,
        state: &mut LoopState,
        index: usize,
        why: &str,
    ) -> Result<(), OutputError> {
        state.finished[index] = true;
        state.not_watching.retain(|other| *other != index);
        let name = self.peers[index].name.clone();
        let goes_on = if state.is_over { "" } else { ", the run goes on" };
        let text = format!("{name} is lost{goes_on}: {why}");
        self.terminal.warn(&text);
        state.notes.insert(name.clone(), format!("lost: {why}"));
        self.peers[index].end(Duration::from_millis(100));
        // Its channels would stay full, and senders of lossless frames would wait for it.
        self.control.clean_after_dead();
        self.forget_in_checkpoints(index)?;
        self.note(LogLevel::Warning, &name, &text)
    }

    /// Gives up lossless observers that took no frame although the start exchange is long over.
    pub(super) fn lose_blind_observers(
        &mut self,
        state: &mut LoopState,
        now: Instant,
    ) -> Result<(), OutputError> {
        if self.monitor.common_window().is_none() {
            return Ok(());
        }
        let begun = *state.begun.get_or_insert(now);
        if now.duration_since(begun) > FIRST_FRAMES {
            for index in std::mem::take(&mut state.not_watching) {
                let why = format!("it took no frame within {} s", FIRST_FRAMES.as_secs());
                self.lose_observer(state, index, &why)?;
            }
        }
        Ok(())
    }

    /// Gives up an observer to which a component sends no more.
    pub(super) fn give_up(
        &mut self,
        state: &mut LoopState,
        name: &str,
        why: &str,
    ) -> Result<(), OutputError> {
        match self.peers.iter().position(|peer| peer.name == name) {
            Some(index) if !state.finished[index] => self.lose_observer(state, index, why),
            _ => Ok(()),
        }
    }

    /// Tells observers that all is sent, and waits until they have written it: as long as each
    /// says that it is there, but no longer than a minute, or the deadline where that is longer.
    pub(super) fn finish_observers(&mut self, state: &mut LoopState, window: u64) {
        let observers: Vec<usize> = (0..self.peers.len())
            .filter(|index| !self.physics.contains(index) && !state.finished[*index])
            .collect();
        for index in &observers {
            let _ = self.control.say(*index, Credit::FINISH, window);
        }
        let begin = Instant::now();
        state.heard.fill(begin);
        let mut told = false;
        while observers.iter().any(|index| !state.finished[*index]) {
            if !told && begin.elapsed() > SILENCE / 2 {
                told = true;
                self.tell_who_closes(state, &observers);
            }
            for index in &observers {
                if let Some(why) = self.waited_enough(state, *index, begin) {
                    let _ = self.lose_observer(state, *index, &why);
                }
            }
            self.take_last_events(state, Duration::from_millis(5));
        }
    }

    /// Says for whom the run waits, which may be long.
    fn tell_who_closes(&self, state: &LoopState, observers: &[usize]) {
        let late = observers.iter().filter(|index| !state.finished[**index]);
        let names: Vec<&str> = late.map(|index| self.peers[*index].name.as_str()).collect();
        let names = names.join(", ");
        self.terminal.say(&format!("waiting for files of {names}; Ctrl-C to end without"));
    }

    /// Handles arrivals when the physics is over: a fault now concerns observers only, and the files that
    /// they write.
    pub(super) fn take_last_events(&mut self, state: &mut LoopState, nap: Duration) {
        if let Err(EndReason::Fault(fault)) = self.take_events(state, nap)
            && fault.kind == FaultKind::Output
        {
            state.spoilt.get_or_insert(*fault);
        }
    }

    /// Reason to wait no longer for observer `index`, told to finish at `begin`; `None` to wait on.
    fn waited_enough(&self, state: &LoopState, index: usize, begin: Instant) -> Option<String> {
        let most = units::wait(self.deadline).max(CLOSING);
        if state.finished[index] {
            None
        } else if self.interrupts.load(Ordering::Relaxed) > state.asked {
            Some("the user did not want to wait for it".into())
        } else if state.heard[index].elapsed() > SILENCE {
            Some(format!("it did not finish: not a word of it within {} s", SILENCE.as_secs()))
        } else if begin.elapsed() > most {
            let seconds = most.as_secs_f64();
            Some(format!("it did not finish within {seconds} s; a longer run.deadline allows more"))
        } else {
            None
        }
    }
}
