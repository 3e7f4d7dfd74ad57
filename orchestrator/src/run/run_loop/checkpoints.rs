//! Checkpoints in the loop of windows.
//!
//! A checkpoint has two phases. First every component with a state copies it at the end of one window
//! and writes the copy while the run goes on; its reply says that the disk has it. Then, when all have
//! replied, the orchestrator adds its own part and gives the folder its name. A run that is killed
//! before leaves a folder without a name, which nobody takes for a checkpoint.
//!
//! The window is one that no component may have begun: it lies beyond all credit when it is named, and
//! the credit for it names it. Observers are told before, and hold back frames of later windows until
//! they have kept their own states.

use super::credit::ASKED_AHEAD;
use super::{LoopState, RunLoop};
use crate::manifest::{Checkpoints, ORCHESTRATOR};
use crate::outputs::{
    CheckpointRecord, ComponentRecord, ComponentTotals, Ending, LogLevel, OutputError,
    UnfinishedCheckpoint, remove_old_checkpoints, remove_unfinished_checkpoints,
};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tremie_channels::ChannelMedium;
use tremie_messages::Role;
use tremie_messages::control::Credit;
use tremie_state::{KeepsState, SavedState, StateError, StateExchange};

/// Longest wait for the replies of components that have ended.
const LAST_REPLIES: Duration = Duration::from_millis(100);

/// Checkpoints of a run.
pub struct CheckpointKeeping {
    /// When they are made, and how many are kept.
    pub when: Checkpoints,
    /// False if a component of the physics has no state: none can be made.
    pub can_be_made: bool,
    /// What they are of, without window, time and lengths of files.
    pub record: CheckpointRecord,
    /// The manifest, as resolved.
    pub manifest: String,
    /// Folder of the outputs.
    pub output: PathBuf,
    pub(super) under_way: Option<UnderWay>,
    /// Signal for which a watchdog asked for one, and the first window that it shall be of.
    asked: Option<(String, u64)>,
    /// Window and time of the last.
    pub(super) last: (u64, Instant),
    /// Window of the newest whole one.
    pub(super) newest: Option<u64>,
}

/// A checkpoint under way.
pub(super) struct UnderWay {
    folder: UnfinishedCheckpoint,
    /// Components that have yet to reply, by index in the peers.
    missing: Vec<usize>,
    /// The orchestrator's own part, once it has taken the rows of the window.
    own: Option<SavedState>,
    record: CheckpointRecord,
    begun: Instant,
    /// Longest time that a component stood still to copy its state.
    copied: Duration,
}

impl UnderWay {
    /// Its window.
    pub(super) fn window(&self) -> u64 {
        self.folder.window()
    }
}

impl CheckpointKeeping {
    /// Keeps checkpoints from window `first` on; the newest that is there already.
    pub fn new(
        when: Checkpoints,
        can_be_made: bool,
        record: CheckpointRecord,
        manifest: String,
        output: PathBuf,
        (first, newest): (u64, Option<u64>),
    ) -> Self {
        remove_unfinished_checkpoints(&output);
        let last = (first, Instant::now());
        let (under_way, asked) = (None, None);
        Self { when, can_be_made, record, manifest, output, under_way, asked, last, newest }
    }

    /// True if any are wanted, and can be made.
    fn are_wanted(&self) -> bool {
        self.can_be_made && self.when.keep > 0
    }

    /// A watchdog asks for one, because of a signal in the row of `window`. One that is under way
    /// will do.
    pub(super) fn ask(&mut self, signal: String, window: u64) {
        let are_wanted = self.are_wanted();
        match &mut self.under_way {
            Some(under_way) => under_way.record.made_for = Some(signal),
            None if are_wanted => self.asked = Some((signal, window + ASKED_AHEAD)),
            None => {}
        }
    }

    /// True if the next is due at `window`.
    fn are_due(&self, window: u64, now: Instant) -> bool {
        if self.asked.as_ref().is_some_and(|(_, asked)| window >= *asked) {
            return true;
        }
        let (last, at) = self.last;
        let by_time = self
            .when
            .every
            .is_some_and(|every| now.duration_since(at) >= Duration::from_secs_f64(every.min(1e9)));
        let by_windows = |windows: u64| window > last && window.is_multiple_of(windows);
        by_time || self.when.windows.is_some_and(by_windows)
    }

    /// The last window that may be granted before the next checkpoint by windows begins. Such checkpoints
    /// are made at the same windows in every run: where the disk is too slow for them, the run waits.
    /// The same holds for one that a watchdog asked for.
    fn last_before(&self, granted: u64) -> u64 {
        let asked = self.asked.as_ref().map_or(u64::MAX, |(_, asked)| granted.max(asked - 1));
        let Some(windows) = self.when.windows.filter(|_| self.are_wanted()) else {
            return asked;
        };
        let begun = self.under_way.as_ref().map_or(0, |under_way| under_way.folder.window());
        asked.min(granted.max(begun) / windows * windows + windows - 1)
    }
}

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Begins a checkpoint, if one is due.
    pub(super) fn look_after_checkpoints(
        &mut self,
        state: &mut LoopState,
        now: Instant,
    ) -> Result<(), OutputError> {
        let next = state.granted.map_or(0, |granted| granted + 1);
        // While the run is held before that window none begins: nobody would make the window.
        let may = state.not_watching.is_empty()
            && next <= self.steering.last_window()
            && self.can_begin_checkpoint(state);
        if may && self.checkpoints.are_due(next, now) {
            self.begin_checkpoint(state, next)?;
        }
        Ok(())
    }

    /// The last window that may be granted before a checkpoint begins.
    pub(super) fn last_before_checkpoint(&self, state: &LoopState) -> u64 {
        let granted = state.granted.unwrap_or(self.first);
        // Where the end leaves no room for one, none begins.
        let last = self.checkpoints.last_before(granted);
        if last + 1 < self.windows { last } else { u64::MAX }
    }

    /// True if a checkpoint can begin now, and the run has at least one window after it.
    pub(super) fn can_begin_checkpoint(&self, state: &LoopState) -> bool {
        let Some(granted) = state.granted else { return false };
        let end = state.last.unwrap_or(self.windows);
        self.checkpoints.are_wanted() && self.checkpoints.under_way.is_none() && granted + 1 < end
    }

    /// Begins the checkpoint of `window`, the first that no component may have begun.
    pub(super) fn begin_checkpoint(
        &mut self,
        state: &LoopState,
        window: u64,
    ) -> Result<(), OutputError> {
        self.checkpoints.last = (window, Instant::now());
        let folder = match UnfinishedCheckpoint::begin(&self.checkpoints.output, window) {
            Ok(folder) => folder,
            Err(error) => return self.lose_checkpoint(window, &error.to_string()),
        };
        let with_state = (0..self.peers.len())
            .filter(|index| self.descriptions[*index].state.is_some() && !state.finished[*index]);
        let missing: Vec<usize> = with_state.collect();
        let observers = missing.iter().filter(|index| self.peers[**index].role == Role::Observer);
        self.control.name_checkpoint(window);
        for index in observers {
            // A broken channel shows itself elsewhere.
            let _ = self.control.say(*index, Credit::ADVANCE, 0);
        }
        let ticks = window * self.clock.ticks_per_window;
        let record = CheckpointRecord {
            made_for: self.checkpoints.asked.take().map(|(signal, _)| signal),
            window,
            time: self.clock.seconds(ticks),
            ..self.checkpoints.record.clone()
        };
        self.checkpoints.under_way = Some(UnderWay {
            folder,
            missing,
            own: None,
            record,
            begun: Instant::now(),
            copied: Duration::ZERO,
        });
        Ok(())
    }

    /// Keeps the orchestrator's own part, when it has taken the row of the checkpoint's window.
    pub(super) fn keep_own_part(
        &mut self,
        state: &LoopState,
        window: u64,
    ) -> Result<(), OutputError> {
        let is_due =
            |under_way: &UnderWay| under_way.folder.window() == window && under_way.own.is_none();
        if !self.checkpoints.under_way.as_ref().is_some_and(is_due) {
            return Ok(());
        }
        let mut own = OwnPart {
            end: match (state.last, &state.reason) {
                (Some(last), Some(Ending::Stopped { reason })) => Some((last, reason.clone())),
                _ => None,
            },
            wall: state.begin.elapsed() + self.wall_before,
        };
        match SavedState::told(|told| self.exchange_own_part(&mut own, told)) {
            Ok(kept) => {
                self.checkpoints.under_way.iter_mut().for_each(|it| it.own = Some(kept.clone()));
                self.look_at_replies()
            }
            Err(error) => self.abandon_checkpoint(&error.to_string()),
        }
    }

    /// A component has written its state: so many bytes, copied in so many nanoseconds.
    pub(super) fn note_kept(
        &mut self,
        index: usize,
        window: u64,
        [bytes, copied]: [u64; 2],
    ) -> Result<(), OutputError> {
        let Some(under_way) = self.checkpoints.under_way.as_mut() else { return Ok(()) };
        if under_way.folder.window() != window {
            return Ok(());
        }
        under_way.missing.retain(|other| *other != index);
        under_way.copied = under_way.copied.max(Duration::from_nanos(copied));
        if let Some(own) = under_way.record.components.get_mut(&self.peers[index].name) {
            own.bytes = bytes;
        }
        self.look_at_replies()
    }

    /// A component could not write its state.
    pub(super) fn note_not_kept(
        &mut self,
        index: usize,
        window: u64,
        why: &str,
    ) -> Result<(), OutputError> {
        let is_its = |it: &UnderWay| it.folder.window() == window;
        if !self.checkpoints.under_way.as_ref().is_some_and(is_its) {
            return Ok(());
        }
        let why = format!("{}: {why}", self.peers[index].name);
        self.abandon_checkpoint(&why)
    }

    /// True while a checkpoint of a window before `window` is being written, by components that are
    /// there.
    pub(super) fn is_being_written(&self, window: u64) -> bool {
        self.checkpoints.under_way.as_ref().is_some_and(|it| {
            it.window() < window
                && it.own.is_some()
                && it.missing.iter().all(|index| !self.peers[*index].closed)
        })
    }

    /// Decides, when the physics is over, whether a checkpoint under way can become whole. It is given up
    /// before observers are told to finish: they are then shown what came after its window, and could
    /// keep nothing else for it.
    pub(super) fn settle_checkpoint(&mut self, state: &mut LoopState) {
        let begin = Instant::now();
        // Components that have ended by now may have written their states before.
        while self.awaits_physics() && begin.elapsed() < LAST_REPLIES {
            self.take_last_events(state, LAST_REPLIES / 100);
        }
        let can_become_whole = |it: &UnderWay| it.own.is_some() && !self.misses_physics(it);
        if !self.checkpoints.under_way.as_ref().is_some_and(can_become_whole) {
            self.checkpoints.under_way = None;
        }
    }

    /// True while a checkpoint under way misses replies of the physics that can still come.
    fn awaits_physics(&self) -> bool {
        self.checkpoints.under_way.as_ref().is_some_and(|it| {
            let closed = |index: &usize| self.physics.contains(index) && self.peers[*index].closed;
            it.own.is_some() && self.misses_physics(it) && !it.missing.iter().any(closed)
        })
    }

    /// True if a checkpoint misses replies of the physics.
    fn misses_physics(&self, under_way: &UnderWay) -> bool {
        under_way.missing.iter().any(|index| self.physics.contains(index))
    }

    /// An observer is gone: no checkpoint waits for it.
    pub(super) fn forget_in_checkpoints(&mut self, index: usize) -> Result<(), OutputError> {
        self.checkpoints.record.components.remove(&self.peers[index].name);
        let Some(under_way) = self.checkpoints.under_way.as_mut() else { return Ok(()) };
        under_way.missing.retain(|other| *other != index);
        under_way.record.components.remove(&self.peers[index].name);
        self.look_at_replies()
    }

    /// Lets observers keep their states once all physics has, and finishes the checkpoint once all have.
    fn look_at_replies(&mut self) -> Result<(), OutputError> {
        let Some(under_way) = &self.checkpoints.under_way else { return Ok(()) };
        if under_way.own.is_none() || self.misses_physics(under_way) {
            return Ok(());
        }
        if !under_way.missing.is_empty() {
            let observers = under_way.missing.clone();
            self.release_observers(&observers);
            return Ok(());
        }
        self.finish_checkpoint()
    }

    fn release_observers(&self, observers: &[usize]) {
        self.control.all_have_kept();
        for index in observers {
            let _ = self.control.say(*index, Credit::ADVANCE, 0);
        }
    }

    fn finish_checkpoint(&mut self) -> Result<(), OutputError> {
        let Some(under_way) = self.checkpoints.under_way.take() else { return Ok(()) };
        let UnderWay { folder, own: Some(own), record, begun, copied, .. } = under_way else {
            return Ok(());
        };
        let (window, bytes) = (record.window, record.components.values().map(|c| c.bytes).sum());
        match folder.finish(&record, &self.checkpoints.manifest, &own) {
            Ok(_) => {
                self.checkpoints.newest = Some(window);
                let keep = self.checkpoints.when.keep as usize;
                remove_old_checkpoints(&self.checkpoints.output, keep);
                let [copied, took] = [copied, begun.elapsed()].map(|time| time.as_secs_f64());
                let size = crate::plan::bytes(bytes);
                let made_for = record.made_for.as_ref();
                let why = made_for.map_or(String::new(), |signal| format!(", because of {signal}"));
                let text = format!(
                    "checkpoint of window {window}: {size}, copied in {copied:.4} s, written {took:.1} s after{why}"
                );
                // Into the file only: wall time decides when checkpoints are made, and recordings of
                // equal runs must be equal.
                let time = record.time;
                self.log.write(LogLevel::Info, ORCHESTRATOR, window, time, &text)
            }
            Err(error) => self.lose_checkpoint(window, &error.to_string()),
        }
    }

    fn abandon_checkpoint(&mut self, why: &str) -> Result<(), OutputError> {
        let Some(under_way) = self.checkpoints.under_way.take() else { return Ok(()) };
        // They hold back frames until then.
        self.release_observers(&under_way.missing);
        self.lose_checkpoint(under_way.folder.window(), why)
    }

    /// A checkpoint was not made: a warning. The run goes on, and the next is tried in its time.
    fn lose_checkpoint(&mut self, window: u64, why: &str) -> Result<(), OutputError> {
        let text = format!("no checkpoint of window {window}: {why}");
        self.terminal.warn(&text);
        self.write_line(LogLevel::Warning, ORCHESTRATOR, window, &text)
    }

    /// Keeps the orchestrator's own state, or puts it back: table of signals, sums of reports, conditions
    /// that end the run.
    pub(super) fn exchange_own_part(
        &mut self,
        own: &mut OwnPart,
        state: &mut StateExchange<'_>,
    ) -> Result<(), StateError> {
        state.within("signals", |state| self.table.exchange(state))?;
        state.within("stop_when", |state| self.stop.exchange(state))?;
        state.within("watch", |state| self.watchdogs.exchange_state(state))?;
        state.value("end", &mut own.end)?;
        state.value("wall", &mut own.wall)?;
        let names = self.physics.iter().map(|index| self.peers[*index].name.clone());
        let mut totals: BTreeMap<String, ComponentTotals> =
            names.clone().zip(self.monitor.totals().iter().copied()).collect();
        state.value("totals", &mut totals)?;
        for (name, own) in names.zip(self.monitor.totals_mut()) {
            *own = totals.get(&name).copied().unwrap_or_default();
        }
        Ok(())
    }
}

/// Parts of the loop's own state that have no other place.
#[derive(Default)]
pub(super) struct OwnPart {
    /// The last window and why it is, where a condition was met. An interrupt ends no run that goes on.
    pub end: Option<(u64, String)>,
    /// Wall time of the windows.
    pub wall: Duration,
}

/// The part of a component in the record of checkpoints.
pub fn component_record(program: &str, state: u32, substeps: u32) -> ComponentRecord {
    ComponentRecord { program: program.into(), state, substeps, bytes: 0 }
}
