//! Observers: they never stop the physics, and are waited for only so long.

use super::{Course, Drive};
use crate::outputs::{Level, OutputError};
use std::time::{Duration, Instant};
use tremie_channels::Between;
use tremie_messages::control::Credit;

/// Longest time for a lossless observer to take the frames of the start exchange.
const FIRST_FRAMES: Duration = Duration::from_secs(10);
/// Longest time for observers to finish their outputs.
const OBSERVERS_FINISH: Duration = Duration::from_secs(5);

impl<S: Between> Drive<'_, S> {
    /// An observer failed: a warning, and nobody waits for it any longer.
    pub(super) fn lose_observer(
        &mut self,
        course: &mut Course,
        index: usize,
        why: &str,
    ) -> Result<(), OutputError> {
        course.finished[index] = true;
        course.not_watching.retain(|other| *other != index);
        let name = self.peers[index].name.clone();
        let text = format!("{name} is lost, the run goes on: {why}");
        self.terminal.warn(&text);
        course.notes.insert(name.clone(), format!("lost: {why}"));
        self.peers[index].end(Duration::from_millis(100));
        self.control.clean_after_dead();
        self.note(Level::Warning, &name, &text)
    }

    /// Gives up observers that take nothing although the start exchange is long over.
    pub(super) fn lose_blind_observers(
        &mut self,
        course: &mut Course,
        now: Instant,
    ) -> Result<(), OutputError> {
        if self.monitor.common_window().is_none() {
            return Ok(());
        }
        let begun = *course.begun.get_or_insert(now);
        if now.duration_since(begun) > FIRST_FRAMES {
            for index in std::mem::take(&mut course.not_watching) {
                let why = format!("it took no frame within {} s", FIRST_FRAMES.as_secs());
                self.lose_observer(course, index, &why)?;
            }
        }
        Ok(())
    }

    /// A component sends no more to an observer: then the observer is of no more use.
    pub(super) fn give_up(
        &mut self,
        course: &mut Course,
        name: &str,
        why: &str,
    ) -> Result<(), OutputError> {
        match self.peers.iter().position(|peer| peer.name == name) {
            Some(index) if !course.finished[index] => self.lose_observer(course, index, why),
            _ => Ok(()),
        }
    }

    /// Tells observers that all is sent, and waits until they have written it.
    pub(super) fn finish_observers(&mut self, course: &mut Course, window: u64) {
        let observers: Vec<usize> = (0..self.peers.len())
            .filter(|index| !self.physics.contains(index) && !course.finished[*index])
            .collect();
        for index in &observers {
            let _ = self.control.say(*index, Credit::FINISH, window);
        }
        let deadline = Instant::now() + OBSERVERS_FINISH;
        while observers.iter().any(|index| !course.finished[*index]) && Instant::now() < deadline {
            // The physics is over: what goes wrong now concerns observers only.
            let _ = self.hear_news(course, Duration::from_millis(5));
        }
        for index in observers {
            if !course.finished[index] {
                let why = format!("it did not finish within {} s", OBSERVERS_FINISH.as_secs());
                let _ = self.lose_observer(course, index, &why);
            }
        }
    }
}
