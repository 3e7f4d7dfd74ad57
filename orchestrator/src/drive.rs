//! The second half of a run: windows go by, guards watch, and everything ends in order.

use crate::control::Control;
use crate::introduction::EarlyLog;
use crate::launch::{News, Peer, Post};
use crate::manifest::ORCHESTRATOR;
use crate::monitor::{Monitor, Row, Waiting};
use crate::outputs::{Ending, Level, OutputError, RunLog, SignalTable};
use crate::stop::StopWatch;
use crate::terminal::{Progress, Terminal};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};
use tremie_channels::{Between, ChannelError};
use tremie_messages::Role;
use tremie_messages::control::Credit;
use tremie_messages::frame::LogHeader;
use tremie_messages::start::{Clock, Description, Fault, FaultKind, Reply};
use tremie_messages::units;

/// How often the orchestrator looks at reports. Physics does not wait for it: credit runs ahead.
const LOOK: Duration = Duration::from_millis(1);
/// Wall time by which credit runs ahead: what a Ctrl-C takes to be heeded.
const CREDIT_AHEAD: f64 = 0.1;
/// Windows by which the end lies behind the one that meets a stop condition: fixed, so that the
/// last window does not depend on how fast the orchestrator looks.
const STOP_AHEAD: u64 = 64;
/// Longest time for a lossless observer to take the frames of the start exchange.
const FIRST_FRAMES: Duration = Duration::from_secs(10);
/// Longest time for observers to finish their outputs.
const OBSERVERS_FINISH: Duration = Duration::from_secs(5);

/// What a run in progress is made of.
pub struct Drive<'a, S: Between> {
    /// Shared memory.
    pub control: Control<S>,
    /// All components, in the order of the plan.
    pub peers: &'a mut [Peer],
    /// What they said at the handshake.
    pub descriptions: &'a [Description],
    /// Where their news arrive.
    pub news: &'a Receiver<Post>,
    /// What they wrote to standard error before.
    pub early: EarlyLog,
    /// What is known of the physics.
    pub monitor: Monitor,
    /// Index of each watched component in `peers`.
    pub physics: Vec<usize>,
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
    pub stop: StopWatch,
    /// Table of signals.
    pub table: SignalTable,
    /// Log of the run.
    pub log: RunLog,
    /// The user.
    pub terminal: &'a mut Terminal,
    /// How often the user has asked for the end.
    pub interrupts: &'a AtomicUsize,
}

/// Why the loop of windows ends before all are done.
enum Trouble {
    /// The user asked again: at once, not in order.
    Impatience,
    Fault(Box<Fault>),
    Output(OutputError),
}

impl From<Fault> for Trouble {
    fn from(fault: Fault) -> Self {
        Self::Fault(Box::new(fault))
    }
}

impl From<OutputError> for Trouble {
    fn from(error: OutputError) -> Self {
        Self::Output(error)
    }
}

impl From<ChannelError> for Trouble {
    fn from(error: ChannelError) -> Self {
        Self::Fault(Box::new(Fault {
            kind: FaultKind::Channel,
            noticed_by: "the orchestrator".into(),
            blamed: "the orchestrator".into(),
            window: 0,
            message: error.to_string(),
        }))
    }
}

/// How a run went.
pub struct Driven {
    /// How it ended.
    pub ending: Ending,
    /// Last window that all components completed.
    pub window: u64,
    /// Sums over the reports of each component of the physics, by index in `peers`.
    pub totals: BTreeMap<usize, crate::monitor::Totals>,
    /// What observers wrote or lost, by name.
    pub observers: BTreeMap<String, String>,
    /// Wall time of the windows.
    pub wall: Duration,
    /// The table of signals, to be closed.
    pub table: SignalTable,
    /// The log of the run.
    pub log: RunLog,
}

/// What changes while windows go by.
struct Course {
    begin: Instant,
    granted: Option<u64>,
    /// Last window of the run, once the end was asked for early.
    last: Option<u64>,
    reason: Option<Ending>,
    /// When the start exchange was over.
    begun: Option<Instant>,
    finished: Vec<bool>,
    /// Lossless observers that have not yet taken a first frame of each stream.
    not_watching: Vec<usize>,
    words: Vec<String>,
    notes: BTreeMap<String, String>,
    /// Window and time of the last measurement of the rate, and the rate.
    mark: (u64, Instant),
    rate: f64,
}

impl<S: Between> Drive<'_, S> {
    /// Lets the windows go by, to the end of the run, whatever that is.
    ///
    /// # Errors
    /// If an output cannot be written; all components were told to end before.
    pub fn run(mut self) -> Result<Driven, OutputError> {
        let now = Instant::now();
        let count = self.peers.len();
        let mut course = Course {
            begin: now,
            granted: None,
            last: None,
            reason: None,
            begun: None,
            finished: vec![false; count],
            not_watching: self.lossless.clone(),
            words: vec![String::new(); count],
            notes: BTreeMap::new(),
            mark: (0, now),
            rate: 0.0,
        };
        let trouble = self.hear_early(&mut course).and_then(|()| self.windows_go_by(&mut course));
        let trouble = trouble.err();
        let wall = course.begin.elapsed();
        let ending = match trouble {
            None => course.reason.take().unwrap_or(Ending::Completed),
            Some(Trouble::Impatience) => {
                self.stop_physics(&course);
                Ending::Interrupted
            }
            Some(Trouble::Fault(fault)) => Ending::Failed { fault: *fault },
            Some(Trouble::Output(error)) => {
                self.stop_physics(&course);
                self.finish_observers(&mut course, 0);
                return Err(error);
            }
        };
        if matches!(ending, Ending::Failed { .. }) {
            self.stop_physics(&course);
        }
        // Rows that were complete when the end came belong to the record.
        let _ = self.take_reports();
        let rows = self.take_last_rows();
        let window = self.monitor.common_window().unwrap_or(0);
        let noted = match &ending {
            Ending::Failed { fault } => {
                self.note(Level::Error, &fault.blamed.clone(), &fault.to_string())
            }
            Ending::Interrupted => Ok(()),
            Ending::Completed | Ending::Stopped { .. } => {
                let text = format!("the run is over at window {window}");
                self.note_at(window, Level::Info, ORCHESTRATOR, &text)
            }
        };
        self.finish_observers(&mut course, window);
        rows.and(noted)?;
        let totals =
            self.physics.iter().copied().zip(self.monitor.totals().iter().copied()).collect();
        let Self { table, log, .. } = self;
        Ok(Driven { ending, window, totals, observers: course.notes, wall, table, log })
    }

    /// What components wrote before windows go by.
    fn hear_early(&mut self, course: &mut Course) -> Result<(), Trouble> {
        let bodies: u64 = self.descriptions.iter().map(|description| description.bodies).sum();
        let (windows, window) = (self.windows, self.clock.window());
        let text = format!("{windows} windows of {window:.4e} s begin, with {bodies} bodies");
        self.note_at(0, Level::Info, ORCHESTRATOR, &text)?;
        for (index, text) in std::mem::take(&mut self.early) {
            self.hear_log(course, index, &text)?;
        }
        Ok(())
    }

    fn take_last_rows(&mut self) -> Result<(), OutputError> {
        while let Some(row) = self.monitor.next_row() {
            self.table.take(row)?;
        }
        Ok(())
    }

    fn windows_go_by(&mut self, course: &mut Course) -> Result<(), Trouble> {
        loop {
            self.hear_news(course, LOOK)?;
            self.take_reports()?;
            self.take_rows(course)?;
            let now = Instant::now();
            if self.physics.iter().all(|index| course.finished[*index]) {
                return Ok(());
            }
            // Later than the components' own deadline: a peer that waits names both sides.
            let deadline = units::wait(1.2 * self.deadline + 0.1);
            let lost = self.monitor.lost_message();
            let granted = course.granted.unwrap_or(0);
            if let Some(fault) = lost.or_else(|| self.monitor.silent(now, granted, deadline)) {
                return Err(fault.into());
            }
            self.lose_blind_observers(course, now)?;
            self.heed_user(course)?;
            self.grant(course, now)?;
            self.show_progress(course, now);
        }
    }

    /// Takes what components said since the last look; sleeps a little if they said nothing.
    fn hear_news(&mut self, course: &mut Course, nap: Duration) -> Result<(), Trouble> {
        let mut nap = nap;
        loop {
            match self.news.recv_timeout(nap) {
                Ok((index, news)) => self.hear(course, index, news)?,
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => return Ok(()),
            }
            nap = Duration::ZERO;
        }
    }

    fn hear(&mut self, course: &mut Course, index: usize, news: News) -> Result<(), Trouble> {
        let watched = self.physics.iter().position(|peer| *peer == index);
        let name = self.peers[index].name.clone();
        match (news, watched) {
            (News::Reply(reply), Some(watched)) => match *reply {
                Reply::Waiting { from, what, owed, since, looked, window } => {
                    let wait = Waiting { from, what, owed, since, looked, window };
                    self.monitor.waiting(watched, wait);
                }
                Reply::Resumed {} => self.monitor.resumed(watched, Instant::now()),
                Reply::Finished { window, .. } => {
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
            },
            (News::Reply(reply), None) => match *reply {
                Reply::Finished { note, .. } => {
                    course.finished[index] = true;
                    course.notes.insert(name, note);
                }
                Reply::Fault(fault) => self.lose_observer(course, index, &fault.message)?,
                Reply::Watching {} => course.not_watching.retain(|other| *other != index),
                _ => {}
            },
            (News::Garbage(text), Some(_)) => {
                let text = format!("it wrote a line that is no reply: {text}");
                return Err(self.broken(index, text));
            }
            (News::Garbage(text) | News::Log(text), _) => self.hear_log(course, index, &text)?,
            (News::Closed, watched) => {
                self.peers[index].closed = true;
                // What it had done before it ended counts.
                self.take_reports()?;
                if course.finished[index] {
                    return Ok(());
                }
                let how = self.peers[index].end(Duration::from_millis(100));
                let last = Some(&course.words[index]).filter(|text| !text.is_empty());
                let words = last.map_or(String::new(), |text| format!("; its last words: {text}"));
                match watched {
                    Some(watched) => {
                        let fault = Fault {
                            kind: FaultKind::Exit,
                            noticed_by: "the orchestrator".into(),
                            blamed: name,
                            window: self.monitor.window_of(watched).map_or(0, |w| w + 1),
                            message: format!("its process {how} in mid-run{words}"),
                        };
                        return Err(fault.into());
                    }
                    None => {
                        self.lose_observer(course, index, &format!("its process {how}{words}"))?
                    }
                }
            }
        }
        Ok(())
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

    /// A component's line on standard error: JSON from the sdk's logger, or anything else.
    fn hear_log(
        &mut self,
        course: &mut Course,
        index: usize,
        text: &str,
    ) -> Result<(), OutputError> {
        let parsed: Option<serde_json::Value> = serde_json::from_str(text).ok();
        let field = |name: &str| parsed.as_ref()?.get(name)?.as_str().map(str::to_string);
        let message = field("message").unwrap_or_else(|| text.to_string());
        let level = match field("level").as_deref() {
            Some("ERROR") => Level::Error,
            Some("WARN") => Level::Warning,
            _ => Level::Info,
        };
        let name = self.peers[index].name.clone();
        match level {
            Level::Info if self.peers[index].role == Role::Observer => self.terminal.say(&message),
            Level::Info => {}
            _ => self.terminal.warn(&format!("{name}: {message}")),
        }
        course.words[index].clone_from(&message);
        // Into the file only: what a component says of itself (a port that it took, say) differs from
        // run to run, and recordings of equal runs are equal.
        let window = self.monitor.common_window().unwrap_or(0);
        let time = self.clock.seconds(window * self.clock.ticks_per_window);
        self.log.write(level, &name, window, time, &message)
    }

    /// An observer failed: a warning, and nobody waits for it any longer.
    fn lose_observer(
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
    fn lose_blind_observers(
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
    fn give_up(&mut self, course: &mut Course, name: &str, why: &str) -> Result<(), OutputError> {
        match self.peers.iter().position(|peer| peer.name == name) {
            Some(index) if !course.finished[index] => self.lose_observer(course, index, why),
            _ => Ok(()),
        }
    }

    fn take_reports(&mut self) -> Result<(), Trouble> {
        let now = Instant::now();
        let monitor = &mut self.monitor;
        for (watched, peer) in self.physics.iter().enumerate() {
            self.control.reports(*peer, |report, signals| {
                Ok::<_, Trouble>(monitor.report(watched, report, signals, now)?)
            })?;
        }
        Ok(())
    }

    fn take_rows(&mut self, course: &mut Course) -> Result<(), Trouble> {
        while let Some(row) = self.monitor.next_row() {
            let Row { window, values, .. } = &row;
            let time = self.clock.seconds(window * self.clock.ticks_per_window);
            if let Some(reason) = self.stop.look(time, values).filter(|_| course.last.is_none()) {
                let last = (window + STOP_AHEAD).min(self.windows);
                let text = format!("{reason}: the run ends at window {last}");
                self.note_at(*window, Level::Info, ORCHESTRATOR, &text)?;
                self.ask_to_finish(course, last, Ending::Stopped { reason })?;
            }
            self.table.take(row)?;
        }
        Ok(())
    }

    fn heed_user(&mut self, course: &mut Course) -> Result<(), Trouble> {
        match self.interrupts.load(Ordering::Relaxed) {
            0 => return Ok(()),
            1 if course.last.is_some() => return Ok(()),
            1 => {}
            _ => return Err(Trouble::Impatience),
        }
        self.note(Level::Info, ORCHESTRATOR, "the user asked for the end")?;
        self.terminal.say("ending in order, with whole outputs; once more to end at once");
        let last = course.granted.unwrap_or(0);
        self.ask_to_finish(course, last, Ending::Interrupted)
    }

    fn ask_to_finish(
        &mut self,
        course: &mut Course,
        last: u64,
        reason: Ending,
    ) -> Result<(), Trouble> {
        course.last = Some(last);
        course.granted = Some(last);
        course.reason = Some(reason);
        for peer in &self.physics {
            self.control.say(*peer, Credit::FINISH, last)?;
        }
        Ok(())
    }

    /// Lets components advance some windows beyond the last that all have completed.
    fn grant(&mut self, course: &mut Course, now: Instant) -> Result<(), Trouble> {
        if course.last.is_some() {
            return Ok(());
        }
        let done = self.monitor.common_window().map_or(0, |window| window + 1);
        let since = now.duration_since(course.mark.1).as_secs_f64();
        if since > 0.05 {
            course.rate = (done - course.mark.0) as f64 / since;
            course.mark = (done, now);
        }
        let most = if self.stop.is_idle() { self.report_depth / 2 } else { STOP_AHEAD };
        if !course.not_watching.is_empty() {
            // Only the start exchange, until they have seen it.
            return self.grant_through(course, 0);
        }
        let ahead = ((course.rate * CREDIT_AHEAD) as u64).clamp(4.min(most), most);
        self.grant_through(course, (done + ahead).min(self.windows))
    }

    fn grant_through(&mut self, course: &mut Course, grant: u64) -> Result<(), Trouble> {
        if course.granted.is_some_and(|granted| granted >= grant) {
            return Ok(());
        }
        if course.granted.is_none_or(|granted| self.monitor.all_wait_for_credit(granted)) {
            self.monitor.granted(Instant::now());
        }
        course.granted = Some(grant);
        for peer in &self.physics {
            self.control.say(*peer, Credit::ADVANCE, grant)?;
        }
        Ok(())
    }

    fn show_progress(&mut self, course: &Course, now: Instant) {
        let window = self.monitor.common_window().unwrap_or(0);
        let elapsed = now.duration_since(course.begin).as_secs_f64();
        let mut progress = Progress {
            window,
            windows: self.windows,
            time: self.clock.seconds(window * self.clock.ticks_per_window),
            rate: course.rate,
            work: Vec::new(),
            shares: Vec::new(),
            bodies: self.descriptions.iter().map(|d| d.bodies).sum(),
        };
        for (watched, peer) in self.physics.iter().enumerate() {
            let totals = self.monitor.totals()[watched];
            let name = &self.peers[*peer].name;
            let share = |nanoseconds: u64| nanoseconds as f64 * 1e-9 / elapsed.max(1e-9);
            progress.shares.push((name.clone(), share(totals.compute), share(totals.wait)));
            let unit = self.descriptions[*peer].work.clone();
            let rate = totals.work as f64 / (totals.compute as f64 * 1e-9).max(1e-9);
            progress.work.push((name.clone(), unit, rate));
        }
        self.terminal.progress(&progress);
    }

    /// Tells physics to end at once, and ends what does not.
    fn stop_physics(&mut self, course: &Course) {
        for index in &self.physics {
            if !course.finished[*index] && !self.peers[*index].closed {
                // A broken channel changes nothing: the component is ended next.
                let _ = self.control.say(*index, Credit::ABORT, 0);
            }
        }
        for index in &self.physics {
            self.peers[*index].end(Duration::from_millis(50));
        }
    }

    /// Tells observers that all is sent, and waits until they have written it.
    fn finish_observers(&mut self, course: &mut Course, window: u64) {
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

    /// Writes a line to the log, and shows it to observers.
    fn note(&mut self, level: Level, from: &str, message: &str) -> Result<(), OutputError> {
        let window = self.monitor.common_window().unwrap_or(0);
        self.note_at(window, level, from, message)
    }

    /// As [`Drive::note`], of a given window: what depends on the physics alone must not depend on
    /// when the orchestrator looked.
    fn note_at(
        &mut self,
        window: u64,
        level: Level,
        from: &str,
        message: &str,
    ) -> Result<(), OutputError> {
        let ticks = window * self.clock.ticks_per_window;
        let code = match level {
            Level::Info => LogHeader::INFO,
            Level::Warning => LogHeader::WARNING,
            Level::Error => LogHeader::ERROR,
        };
        let mut header = LogHeader { level: code, ..LogHeader::default() };
        (header.stamp.window, header.stamp.ticks) = (window, ticks);
        self.control.log(header, &format!("{from}: {message}"));
        self.log.write(level, from, window, self.clock.seconds(ticks), message)
    }
}
