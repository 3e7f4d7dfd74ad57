//! The queue of runs: processes of this program, as many at once as the machine has cores for.

use super::folder::FolderUse;
use super::results::{StudyEnd, StudyResults, last_words};
use super::shared_runs::RunPlace;
use super::threads::{ThreadShare, may_begin};
use super::{Study, StudyError};
use crate::run::handshake::cores;
use crate::run::launch::this_program;
use crate::terminal::Terminal;
use rustix::process::{Pid, Signal, kill_process};
use std::collections::{BTreeSet, VecDeque};
use std::fs::File;
use std::os::unix::process::CommandExt;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Time between looks at the runs.
const LOOK: Duration = Duration::from_millis(20);

/// The runs of studies while they are made, study by study.
pub struct RunQueue<'a> {
    results: StudyResults<'a>,
    interrupts: &'a AtomicUsize,
    /// Most runs at once, if the command says so.
    jobs: Option<usize>,
    /// Cores that this program may use.
    cores: u32,
    /// Runs that wait.
    waiting: VecDeque<RunPlace>,
    going_on: Vec<RunningRun>,
    /// Interrupts that the runs were told.
    told: usize,
}

/// A run that is under way.
struct RunningRun {
    place: RunPlace,
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
        studies: &'a [Study],
        jobs: Option<usize>,
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
    ) -> Self {
        let results = StudyResults::read(studies, terminal, interrupts);
        let (waiting, going_on) = (VecDeque::new(), Vec::new());
        Self { results, interrupts, jobs, cores: cores(), waiting, going_on, told: 0 }
    }

    /// Makes all runs that are left. After an interrupt those under way end in order, and none begins.
    /// Returns what became of each study.
    ///
    /// Must be called from a thread that outlives the runs: they end with it.
    ///
    /// # Errors
    /// If the study's own files cannot be written or a run cannot be started; the runs have ended then.
    pub fn make_all(mut self) -> Result<Vec<StudyEnd>, StudyError> {
        let outcome = self.go_on();
        if outcome.is_err() {
            self.send(Signal::INT);
            for running in &mut self.going_on {
                let _ = running.child.wait();
            }
        }
        outcome?;
        Ok(self.results.end())
    }

    fn go_on(&mut self) -> Result<(), StudyError> {
        self.waiting = self.results.begin(BTreeSet::new())?.into();
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

    fn share(&self, place: RunPlace) -> ThreadShare {
        self.results.run(place).threads.share(self.cores, self.jobs)
    }

    /// Starts runs that wait, in their order, as long as they fit.
    fn begin_runs(&mut self) -> Result<(), StudyError> {
        // Each is looked at once: one whose folder is taken goes to the end.
        for _ in 0..self.waiting.len() {
            let Some(&place) = self.waiting.front() else { break };
            let going_on: Vec<u32> = self.going_on.iter().map(|run| run.threads).collect();
            let jobs = self.jobs.unwrap_or(usize::MAX);
            if !may_begin(&going_on, self.share(place).threads, jobs, self.cores) {
                break;
            }
            self.waiting.pop_front();
            match self.results.use_of(place)? {
                FolderUse::UnderWay => {
                    self.waiting.push_back(place);
                    continue;
                }
                // Somebody else has made it meanwhile.
                FolderUse::Done => {
                    self.waiting.extend(self.results.take(place)?);
                    continue;
                }
                FolderUse::BrokenOff => self.start(place, true)?,
                FolderUse::Unfinished => {
                    self.results.remove(place)?;
                    self.start(place, false)?;
                }
                FolderUse::Free => self.start(place, false)?,
            }
        }
        Ok(())
    }

    /// Starts a run, or goes on with it.
    fn start(&mut self, place: RunPlace, resumes: bool) -> Result<(), StudyError> {
        let (study, run) = (self.results.study(place), self.results.run(place));
        let wrong = StudyError::io(study.folder.path());
        let words = tempfile::tempfile().map_err(&wrong)?;
        let mut command = this_program();
        let share = self.share(place);
        command.args(if resumes {
            study.resuming_arguments(run, &run.threads.resuming_sets(&share, self.cores))
        } else {
            study.arguments(run, &share)
        });
        command.stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(words.try_clone().map_err(&wrong)?);
        // A group of its own: Ctrl-C reaches this program alone, which passes it on once.
        let child = command.process_group(0).spawn().map_err(&wrong)?;
        let threads = share.threads;
        self.going_on.push(RunningRun { place, child, words, threads, resumes });
        Ok(())
    }

    /// Takes the results of runs that have ended.
    fn collect(&mut self) -> Result<(), StudyError> {
        let mut next = 0;
        while next < self.going_on.len() {
            let ended = self.going_on[next].child.try_wait();
            if matches!(ended, Ok(None)) {
                next += 1;
                continue;
            }
            let mut running = self.going_on.remove(next);
            let place = running.place;
            if self.told > 0 && !self.results.is_done(place) {
                // It was ended, and will be made again.
                continue;
            }
            if self.results.use_of(place)? == FolderUse::UnderWay {
                // A run of a study that was killed had the folder still.
                self.waiting.push_back(place);
                continue;
            }
            if running.resumes && !self.results.is_done(place) {
                // Of another program, or with a state that is damaged: from the start, then.
                self.results.remove(place)?;
                self.waiting.push_front(place);
                continue;
            }
            let left = self.results.take_made(place, || last_words(&mut running.words))?;
            if self.told == 0 {
                self.waiting.extend(left);
            }
        }
        Ok(())
    }
}
