//! The queue of runs: processes of this program, as many at once as the machine has cores for.

use super::folder::FolderUse;
use super::results::{StudyEnd, StudyResults, last_words};
use super::threads::{ThreadShare, may_begin};
use super::{Study, StudyError};
use crate::run::handshake::cores;
use crate::run::launch::this_program;
use crate::terminal::Terminal;
use rustix::process::{Pid, Signal, kill_process};
use std::collections::VecDeque;
use std::fs::File;
use std::os::unix::process::CommandExt;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Time between looks at the runs.
const LOOK: Duration = Duration::from_millis(20);

/// The runs of a study while they are made.
pub struct RunQueue<'a> {
    study: &'a Study,
    results: StudyResults<'a>,
    interrupts: &'a AtomicUsize,
    /// Most runs at once.
    jobs: usize,
    shares: Vec<ThreadShare>,
    /// Runs that wait, by their numbers.
    waiting: VecDeque<usize>,
    going_on: Vec<RunningRun>,
    /// Interrupts that the runs were told.
    told: usize,
}

/// A run that is under way.
struct RunningRun {
    index: usize,
    child: Child,
    /// Its standard error.
    words: File,
    threads: u32,
    /// It goes on from a checkpoint.
    resumes: bool,
}

impl<'a> RunQueue<'a> {
    /// The queue of all runs that are not done.
    pub fn new(
        study: &'a Study,
        jobs: Option<usize>,
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
    ) -> Self {
        let shares = study.runs.iter().map(|run| run.threads.share(cores(), jobs)).collect();
        let results = StudyResults::read(study, terminal);
        let waiting = results.left().collect();
        let jobs = jobs.unwrap_or(usize::MAX);
        let going_on = Vec::new();
        Self { study, results, interrupts, jobs, shares, waiting, going_on, told: 0 }
    }

    /// Makes all runs that wait. After an interrupt those under way end in order, and none begins.
    ///
    /// Must be called from a thread that outlives the runs: they end with it.
    ///
    /// # Errors
    /// If the study's own files cannot be written or a run cannot be started; the runs have ended then.
    pub fn make_all(mut self) -> Result<StudyEnd, StudyError> {
        let outcome = self.go_on();
        if outcome.is_err() {
            self.send(Signal::INT);
            for running in &mut self.going_on {
                let _ = running.child.wait();
            }
        }
        outcome?;
        Ok(self.results.end(self.told > 0))
    }

    fn go_on(&mut self) -> Result<(), StudyError> {
        self.results.write()?;
        while !(self.waiting.is_empty() && self.going_on.is_empty()) {
            self.heed_interrupts();
            self.begin_runs()?;
            self.collect()?;
            self.results.show(self.going_on.len(), self.waiting.len());
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Tells the runs of each interrupt: the first ends them in order, the second at once.
    fn heed_interrupts(&mut self) {
        let interrupts = self.interrupts.load(Ordering::Relaxed);
        if interrupts == self.told {
            return;
        }
        if self.told == 0 && !self.going_on.is_empty() {
            let count = self.going_on.len();
            self.results.terminal.say(&format!("runs under way end in order: {count}"));
        }
        self.told = interrupts;
        self.waiting.clear();
        self.send(Signal::INT);
    }

    fn send(&self, signal: Signal) {
        for running in &self.going_on {
            // One that has ended is not collected yet: its number is not another's.
            let _ = kill_process(Pid::from_child(&running.child), signal);
        }
    }

    /// Starts runs that wait, in their order, as long as they fit.
    fn begin_runs(&mut self) -> Result<(), StudyError> {
        // Each is looked at once: one whose folder is taken goes to the end.
        for _ in 0..self.waiting.len() {
            let Some(&index) = self.waiting.front() else { break };
            let going_on: Vec<u32> = self.going_on.iter().map(|run| run.threads).collect();
            if !may_begin(&going_on, self.shares[index].threads, self.jobs, cores()) {
                break;
            }
            self.waiting.pop_front();
            let run = &self.study.runs[index];
            match self.study.folder.use_of(run)? {
                FolderUse::UnderWay => {
                    self.waiting.push_back(index);
                    continue;
                }
                // Somebody else has made it meanwhile.
                FolderUse::Done => {
                    self.results.take(index)?;
                    continue;
                }
                FolderUse::BrokenOff => self.start(index, true)?,
                FolderUse::Unfinished => {
                    self.study.folder.remove(run)?;
                    self.start(index, false)?;
                }
                FolderUse::Free => self.start(index, false)?,
            }
        }
        Ok(())
    }

    /// Starts a run, or goes on with it.
    fn start(&mut self, index: usize, resumes: bool) -> Result<(), StudyError> {
        let wrong = |error| StudyError::Io { path: self.study.folder.path().into(), error };
        let words = tempfile::tempfile().map_err(wrong)?;
        let run = &self.study.runs[index];
        let mut command = this_program();
        let share = &self.shares[index];
        command.args(if resumes {
            self.study.resuming_arguments(run, &run.threads.resuming_sets(share, cores()))
        } else {
            self.study.arguments(run, share)
        });
        command.stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(words.try_clone().map_err(wrong)?);
        // A group of its own: Ctrl-C reaches this program alone, which passes it on once.
        let child = command.process_group(0).spawn().map_err(wrong)?;
        let threads = share.threads;
        self.going_on.push(RunningRun { index, child, words, threads, resumes });
        Ok(())
    }

    /// Takes the results of runs that have ended.
    fn collect(&mut self) -> Result<(), StudyError> {
        let mut place = 0;
        while place < self.going_on.len() {
            let ended = self.going_on[place].child.try_wait();
            if matches!(ended, Ok(None)) {
                place += 1;
                continue;
            }
            let mut running = self.going_on.remove(place);
            let index = running.index;
            if self.told > 0 && !self.results.is_done(index) {
                // It was ended, and will be made again.
                continue;
            }
            if self.study.folder.use_of(&self.study.runs[index])? == FolderUse::UnderWay {
                // A run of a study that was killed had the folder still.
                self.waiting.push_back(index);
                continue;
            }
            if running.resumes && !self.results.is_done(index) {
                // Of another program, or with a state that is damaged: from the start, then.
                self.study.folder.remove(&self.study.runs[index])?;
                self.waiting.push_front(index);
                continue;
            }
            self.results.take_made(index, || last_words(&mut running.words))?;
        }
        Ok(())
    }
}
