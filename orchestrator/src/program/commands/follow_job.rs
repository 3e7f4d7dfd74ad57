//! A run at Slurm, followed until it ends: in the queue, at work on whatever machine, and Slurm's word on it.

use super::INTERRUPTED;
use super::attach::{LocalLooks, show};
use crate::steering::{LivingRun, RunStatus, SteeringCommand, living};
use crate::terminal::Terminal;
use crate::tools::shell::shell_word;
use crate::tools::slurm::{
    FILES_SEEN, JobState, QueuedJob, RunJob, SlurmError, StepStatuses, step_of,
};
use serde_json::Value;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};

/// Time between looks at Slurm's queue.
const LOOK: Duration = Duration::from_secs(2);
/// The same where nothing has changed for `QUIET`: a job may wait for days, and each look costs Slurm some work.
const LATE_LOOK: Duration = Duration::from_secs(10);
/// See `LATE_LOOK`.
const QUIET: Duration = Duration::from_secs(60);
/// Interval of the looks at interrupts.
const PAUSE: Duration = Duration::from_millis(50);
/// Time in which a job's run must be seen on this machine; then it is looked for on the job's.
const NEARBY: Duration = Duration::from_secs(5);
/// Time between steps in the job that did not reach the run: each costs Slurm some work.
const STEPS: Duration = Duration::from_secs(15);
/// Longest time for which Slurm may not answer.
const SILENCE: Duration = Duration::from_secs(120);

/// One who follows the job of a run.
pub(super) struct JobFollower<'a> {
    job: RunJob,
    /// Folder of the run's outputs, an absolute path.
    out: &'a Path,
    terminal: &'a mut Terminal,
    interrupts: &'a AtomicUsize,
    /// A program reads what the run says of itself.
    for_program: bool,
    /// The last that was told of the queue.
    told: String,
    /// When there was news last.
    news: Instant,
    /// When the job was first seen to run.
    running: Option<Instant>,
    /// When a step in it has not reached the run.
    unreached: Option<Instant>,
}

impl<'a> JobFollower<'a> {
    pub(super) fn new(
        job: RunJob,
        out: &'a Path,
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
        for_program: bool,
    ) -> Self {
        Self {
            job,
            out,
            terminal,
            interrupts,
            for_program,
            told: String::new(),
            news: Instant::now(),
            running: None,
            unreached: None,
        }
    }

    /// Follows the job to its end. The exit code is that of the run.
    pub(super) fn follow(mut self) -> ExitCode {
        let mut heard = Instant::now();
        loop {
            match self.job.in_queue() {
                Ok(None) => return self.tell_end(),
                Ok(Some(queued)) => {
                    heard = Instant::now();
                    self.look_at(&queued);
                }
                Err(error) if heard.elapsed() > SILENCE => return self.give_up(&error),
                // A controller that restarts is back soon.
                Err(_) => {}
            }
            if !self.pause(if self.news.elapsed() < QUIET { LOOK } else { LATE_LOOK }) {
                return self.tell_how_it_goes_on();
            }
        }
    }

    fn is_interrupted(&self) -> bool {
        self.interrupts.load(Ordering::Relaxed) > 0
    }

    /// Waits; false after an interrupt.
    fn pause(&self, time: Duration) -> bool {
        let begin = Instant::now();
        while !self.is_interrupted() && begin.elapsed() < time {
            std::thread::sleep(PAUSE);
        }
        !self.is_interrupted()
    }

    /// Tells what the queue says, and shows the run while it makes windows.
    fn look_at(&mut self, queued: &QueuedJob) {
        let QueuedJob { job, reason, nodes, .. } = queued;
        if queued.state == JobState::Waiting {
            let why = if reason == "None" { String::new() } else { format!(": {reason}") };
            return self.tell(format!("job {job} waits in Slurm's queue{why}"));
        }
        self.tell(format!("job {job} is on {nodes}"));
        let running = *self.running.get_or_insert_with(Instant::now);
        if let Some((run, status)) = self.run_here() {
            let mut looks = LocalLooks::new(run, self.out);
            return self.show(status, || looks.next());
        }
        let is_due = self.unreached.is_none_or(|tried| tried.elapsed() > STEPS);
        if running.elapsed() > NEARBY && is_due && !self.is_run_over() {
            self.show_from_there();
        }
    }

    fn tell(&mut self, text: String) {
        if text != self.told {
            self.terminal.say(&text);
            self.told = text;
            self.news = Instant::now();
        }
    }

    /// True if the run has ended, and only Slurm's job has not.
    fn is_run_over(&self) -> bool {
        self.job.summary(self.out).is_some()
    }

    /// The job's run, if it is on this machine and makes windows.
    fn run_here(&self) -> Option<(LivingRun, RunStatus)> {
        let is_it = |run: &LivingRun| run.out().as_deref() == Some(self.out);
        let run = living().ok()?.into_iter().find(is_it)?;
        let status = run.status().ok()?;
        Some((run, status))
    }

    /// Shows the run by a step of its job, which looks at it where it is.
    fn show_from_there(&mut self) {
        let words = SteeringCommand::Status {}.words(self.out);
        let step = step_of(self.job.name(), words).and_then(StepStatuses::start);
        let Ok(step) = step else { return self.tell_unreached() };
        let interrupts = self.interrupts;
        let next = || loop {
            match step.newest(PAUSE) {
                Ok(status) => return Some(status),
                Err(RecvTimeoutError::Timeout) if interrupts.load(Ordering::Relaxed) == 0 => {}
                Err(_) => return None,
            }
        };
        match next() {
            Some(first) => {
                self.show(first, next);
                self.unreached = None;
            }
            None => self.tell_unreached(),
        }
    }

    fn tell_unreached(&mut self) {
        // The first try may have come before the run was ready.
        if self.unreached.replace(Instant::now()).is_some() && !self.is_interrupted() {
            let log = self.out.join(crate::outputs::LOG);
            self.tell(format!("the run cannot be seen from here; its log is {}", log.display()));
        }
    }

    fn show(&mut self, first: RunStatus, mut next: impl FnMut() -> Option<RunStatus>) {
        let interrupts = self.interrupts;
        let next = || next().filter(|_| interrupts.load(Ordering::Relaxed) == 0);
        show(first, next, self.terminal, self.for_program);
        self.news = Instant::now();
    }

    /// Tells what became of the run, once Slurm has the job no more.
    fn tell_end(self) -> ExitCode {
        let begin = Instant::now();
        let mut summary = self.job.summary(self.out);
        while summary.is_none() && begin.elapsed() < FILES_SEEN && !self.is_interrupted() {
            std::thread::sleep(PAUSE);
            summary = self.job.summary(self.out);
        }
        let end = self.job.end();
        let mut lines = self.job.last_words();
        // A program that ended by itself has said why.
        if !(end.is_completed() || end.has_failed() && summary.is_some()) {
            lines.insert(0, end.word());
        }
        let out = shell_word(self.out.as_os_str());
        match &summary {
            None => lines.push(format!(
                "the run has no end; `tremie resume {out} --slurm` goes on where it has a checkpoint"
            )),
            Some(summary) if lines.is_empty() => {
                let status = summary["status"].as_str().unwrap_or("ended");
                lines.push(format!("{status}: {} windows; outputs in {out}", summary["windows"]));
            }
            Some(_) => {}
        }
        let status = summary.as_ref().and_then(|summary| summary["status"].as_str());
        let code = match status {
            Some("completed" | "stopped") => ExitCode::SUCCESS,
            Some("interrupted") => ExitCode::from(INTERRUPTED),
            _ => ExitCode::FAILURE,
        };
        self.terminal.end(&lines.join("\n"), summary.unwrap_or(Value::Null));
        code
    }

    fn tell_how_it_goes_on(self) -> ExitCode {
        let text = how_it_goes_on(&self.job, self.out);
        self.terminal.end(&text, Value::Null);
        ExitCode::from(INTERRUPTED)
    }

    fn give_up(self, error: &SlurmError) -> ExitCode {
        let text =
            format!("Slurm does not answer: {error}; {}", how_it_goes_on(&self.job, self.out));
        self.terminal.fail(&text);
        ExitCode::FAILURE
    }
}

/// How a user follows a job that nobody follows, and how it is ended.
pub(super) fn how_it_goes_on(job: &RunJob, out: &Path) -> String {
    let (job, out) = (job.name(), shell_word(out.as_os_str()));
    format!("job {job} goes on at Slurm; `tremie attach {out}` follows it, `scancel {job}` ends it")
}
