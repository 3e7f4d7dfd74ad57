//! The loop of windows: reports and rows come in, guards watch, and everything ends in order.

mod checkpoints;
mod component_events;
mod credit;
mod end_reason;
mod ends;
mod log;
mod observers;
mod pace;
mod progress;
mod steering;
mod watch;
mod windows;

use crate::outputs::ScheduleTiming;
use crate::outputs::{Breach, Ending, RunLog, SignalTable, Trace};
use crate::outputs::{ComponentTotals, RankTimes, WholeCheckpoint};
use crate::run::control::Control;
use crate::run::last_words::LastWords;
use crate::run::launch::{Peer, PeerEvent};
use crate::run::monitor::Monitor;
use crate::run::startup_log::EarlyLog;
use crate::run::stop_conditions::StopConditions;
use crate::run::watchdogs::Watchdogs;
use crate::terminal::Terminal;
use checkpoints::OwnPart;
pub use checkpoints::{CheckpointKeeping, component_record};
use end_reason::EndReason;
use pace::Pace;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::atomic::AtomicUsize;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};
pub use steering::{Change, Steering};
use tremie_channels::ChannelMedium;
use tremie_messages::schedule::Schedule;
use tremie_messages::start::{Clock, Description, Fault};
use tremie_state::StateError;

/// Parts of a run in progress.
pub struct RunLoop<'a, S: ChannelMedium> {
    /// Shared memory.
    pub control: Control<S>,
    /// All components, in the order of the plan.
    pub peers: &'a mut [Peer],
    /// Their descriptions.
    pub descriptions: &'a [Description],
    /// Channel on which their replies, log lines and ends arrive.
    pub news: &'a Receiver<PeerEvent>,
    /// Lines that they wrote to standard error before.
    pub early: EarlyLog,
    /// Progress of the physics.
    pub monitor: Monitor,
    /// Index of each watched component in `peers`.
    pub physics: Vec<usize>,
    /// Threads that each component may use.
    pub threads: Vec<u32>,
    /// Order in which fluid and grains advance.
    pub schedule: Schedule,
    /// Indices of the observers that must not lose a frame.
    pub lossless: Vec<usize>,
    /// Ticks and windows.
    pub clock: Clock,
    /// Windows of the whole run.
    pub windows: u64,
    /// Most reports under way.
    pub report_depth: u64,
    /// Longest wait for a peer [s].
    pub deadline: f64,
    /// Conditions that end the run early.
    pub stop: StopConditions,
    /// Signals that stop the run where the physics goes wrong.
    pub watchdogs: Watchdogs,
    /// Table of signals.
    pub table: SignalTable,
    /// Log of the run.
    pub log: RunLog,
    /// Trace of the run, if it is wanted.
    pub trace: Option<Trace>,
    /// The user.
    pub terminal: &'a mut Terminal,
    /// Number of the user's interrupts.
    pub interrupts: &'a AtomicUsize,
    /// Checkpoints.
    pub checkpoints: CheckpointKeeping,
    /// What users want of the run while it is in progress.
    pub steering: Steering,
    /// Window from whose end the run goes on; 0 if it begins.
    pub first: u64,
    /// Wall time of the windows before.
    pub wall_before: Duration,
}

/// Result of the loop of windows.
pub struct LoopOutcome {
    /// Ending of the run.
    pub ending: Ending,
    /// Last window that all components completed.
    pub window: u64,
    /// Sums over the reports of each component of the physics, by index in `peers`.
    pub totals: BTreeMap<usize, ComponentTotals>,
    /// Times of the ranks of components that have some, in traced windows, by index in `peers`.
    pub ranks: BTreeMap<usize, RankTimes>,
    /// Shares of a window's wall time, if there are components to share it.
    pub turns: Option<ScheduleTiming>,
    /// Outputs that observers wrote or lost, by name.
    pub observers: BTreeMap<String, String>,
    /// Wall time of the windows.
    pub wall: Duration,
    /// The table of signals, closed.
    pub table: SignalTable,
    /// Window of the newest checkpoint.
    pub checkpoint: Option<u64>,
    /// A change of the manifest for which the run ended.
    pub change: Option<Change>,
}

/// State of the loop.
struct LoopState {
    begin: Instant,
    granted: Option<u64>,
    /// Last window of the run, once the end was asked for early.
    last: Option<u64>,
    reason: Option<Ending>,
    /// A watched quantity that has passed its limit.
    breach: Option<Box<Breach>>,
    /// The end that a condition had set before the checkpoint from which the run goes on.
    resumed_end: Option<(u64, String)>,
    /// Number of the user's interrupts at the last look.
    asked: usize,
    /// Time at which the start exchange was first seen over.
    begun: Option<Instant>,
    finished: Vec<bool>,
    /// Lossless observers that have not yet taken a first frame of each stream.
    not_watching: Vec<usize>,
    words: Vec<LastWords>,
    /// Time of each observer's last progress, once it was told to finish.
    heard: Vec<Instant>,
    /// Fault that spoilt the outputs of an observer, once physics is over.
    spoilt: Option<Fault>,
    /// Physics is over.
    is_over: bool,
    notes: BTreeMap<String, String>,
    /// Times of the ranks of components that have some.
    ranks: BTreeMap<usize, RankTimes>,
    /// Windows a second.
    pace: Pace,
    /// The user has seen the shares of a window's time.
    shown_timing: bool,
    /// Time of the last timings to observers.
    sent_timings: Option<Instant>,
}

impl LoopState {
    fn begin(peers: usize, lossless: &[usize]) -> Self {
        let now = Instant::now();
        Self {
            begin: now,
            granted: None,
            last: None,
            reason: None,
            breach: None,
            resumed_end: None,
            asked: 0,
            begun: None,
            finished: vec![false; peers],
            not_watching: lossless.to_vec(),
            words: vec![LastWords::default(); peers],
            heard: vec![now; peers],
            spoilt: None,
            is_over: false,
            notes: BTreeMap::new(),
            ranks: BTreeMap::new(),
            pace: Pace::new(now),
            shown_timing: false,
            sent_timings: None,
        }
    }
}

impl<S: ChannelMedium> RunLoop<'_, S> {
    /// Runs the windows to the end of the run, and closes its outputs.
    ///
    /// # Errors
    /// Where it goes on from a checkpoint, if the orchestrator's part of that cannot be put back.
    pub fn run(mut self, from: Option<&WholeCheckpoint>) -> Result<LoopOutcome, StateError> {
        let mut state = LoopState::begin(self.peers.len(), &self.lossless);
        if let Some(from) = from {
            let mut own = OwnPart::default();
            from.put_back(|told| self.exchange_own_part(&mut own, told))?;
            (state.resumed_end, self.wall_before) = (own.end, own.wall);
        }
        let went = self.write_startup_log(&mut state).and_then(|()| self.run_windows(&mut state));
        if let Err(EndReason::Fault(fault)) = &went {
            // At once: what follows may take a while.
            self.terminal.event(json!({"event": "fault", "fault": fault}));
        }
        let wall = self.wall_before + state.begin.elapsed();
        let mut ending = self.conclude(&mut state, went.err());
        state.is_over = true;
        self.settle_checkpoint(&mut state);
        // Rows that were complete when the end came belong to the record.
        let _ = self.take_reports();
        self.send_timings(&mut state, Instant::now());
        let rows = self.take_last_rows().and_then(|()| self.table.close());
        let traced = self.trace.take().map_or(Ok(()), Trace::close);
        let window = self.monitor.common_window().unwrap_or(0);
        if let Err(error) = rows.and(traced) {
            ending.spoil(error.into_fault(window));
        }
        // Before observers finish: the line is part of their recordings.
        if let Err(error) = self.log_ending(&ending, window) {
            ending.spoil(error.into_fault(window));
        }
        self.finish_observers(&mut state, window);
        if let Some(fault) = state.spoilt.take() {
            ending.spoil(fault);
        }
        let turns = self.turns(window);
        let totals =
            self.physics.iter().copied().zip(self.monitor.totals().iter().copied()).collect();
        Ok(LoopOutcome {
            ending,
            window,
            totals,
            ranks: state.ranks,
            turns,
            observers: state.notes,
            wall,
            table: self.table,
            checkpoint: self.checkpoints.newest,
            change: self.steering.taken,
        })
    }
}
