//! The queue of runs: processes of this program, as many at once as the machine has cores for.

use super::folder::{FolderUse, RunOutcome};
use super::table::{RunResults, write_tables};
use super::threads::{ThreadShare, may_begin};
use super::{Study, StudyError};
use crate::run::handshake::cores;
use crate::run::launch::this_program;
use crate::terminal::{RunsProgress, Terminal};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::json;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek};
use std::os::unix::process::CommandExt;
use std::process::{Child, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Time between looks at the runs.
const LOOK: Duration = Duration::from_millis(20);
/// Most failures that are told in full.
const MOST_TOLD: usize = 20;

/// The runs of a study while they are made.
pub struct RunQueue<'a> {
    study: &'a Study,
    terminal: &'a mut Terminal,
    interrupts: &'a AtomicUsize,
    /// Most runs at once.
    jobs: usize,
    shares: Vec<ThreadShare>,
    /// Runs that wait, by their numbers.
    waiting: VecDeque<usize>,
    going_on: Vec<RunningRun>,
    /// Results of the runs that have ended.
    results: Vec<Option<RunResults>>,
    /// Runs that this study made.
    made: usize,
    failed: usize,
    /// Interrupts that the runs were told.
    told: usize,
    begin: Instant,
}

/// A run that is under way.
struct RunningRun {
    index: usize,
    child: Child,
    /// Its standard error.
    words: File,
    threads: u32,
}

/// What became of the runs of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyEnd {
    /// Results of all runs that have ended.
    pub results: Vec<Option<RunResults>>,
    /// Runs that were made now.
    pub made: usize,
    /// Runs that failed.
    pub failed: usize,
    /// The user ended the study.
    pub is_interrupted: bool,
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
        let of_done = |run| {
            let outcome = study.folder.outcome(run).filter(RunOutcome::is_done)?;
            Some(RunResults::read(&study.folder, run, &study.columns, outcome))
        };
        let results: Vec<_> = study.runs.iter().map(of_done).collect();
        let waiting = (0..results.len()).filter(|index| results[*index].is_none()).collect();
        Self {
            study,
            terminal,
            interrupts,
            jobs: jobs.unwrap_or(usize::MAX),
            shares,
            waiting,
            going_on: Vec::new(),
            results,
            made: 0,
            failed: 0,
            told: 0,
            begin: Instant::now(),
        }
    }

    /// Runs that are done already.
    pub fn done(&self) -> usize {
        self.results.iter().flatten().count()
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
        Ok(StudyEnd {
            results: self.results,
            made: self.made,
            failed: self.failed,
            is_interrupted: self.told > 0,
        })
    }

    fn go_on(&mut self) -> Result<(), StudyError> {
        self.write()?;
        while !(self.waiting.is_empty() && self.going_on.is_empty()) {
            self.heed_interrupts();
            self.begin_runs()?;
            self.collect()?;
            self.show();
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
            self.terminal.say(&format!("runs under way end in order: {count}"));
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
                    self.take(index)?;
                    continue;
                }
                FolderUse::Unfinished => self.study.folder.remove(run)?,
                FolderUse::Free => {}
            }
            let running = self.start(index)?;
            self.going_on.push(running);
        }
        Ok(())
    }

    fn start(&self, index: usize) -> Result<RunningRun, StudyError> {
        let wrong = |error| StudyError::Io { path: self.study.folder.path().into(), error };
        let words = tempfile::tempfile().map_err(wrong)?;
        let mut command = this_program();
        command.args(self.study.arguments(&self.study.runs[index], &self.shares[index]));
        command.stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(words.try_clone().map_err(wrong)?);
        // A group of its own: Ctrl-C reaches this program alone, which passes it on once.
        let child = command.process_group(0).spawn().map_err(wrong)?;
        Ok(RunningRun { index, child, words, threads: self.shares[index].threads })
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
            if self.told > 0 && !self.is_done(index) {
                // It was ended, and will be made again.
                continue;
            }
            if self.study.folder.use_of(&self.study.runs[index])? == FolderUse::UnderWay {
                // A run of a study that was killed had the folder still.
                self.waiting.push_back(index);
                continue;
            }
            self.made += 1;
            if !self.is_done(index) {
                self.failed += 1;
                self.tell_failure(index, &words_of(&mut running.words));
            }
            self.take(index)?;
        }
        Ok(())
    }

    fn is_done(&self, index: usize) -> bool {
        let outcome = self.study.folder.outcome(&self.study.runs[index]);
        outcome.is_some_and(|outcome| outcome.is_done())
    }

    /// Takes the results of a run, and writes the tables anew.
    fn take(&mut self, index: usize) -> Result<(), StudyError> {
        let run = &self.study.runs[index];
        // A run that the manifest's components refuse has no summary.
        let refused = || RunOutcome { status: "failed".into(), wall_time: None };
        let outcome = self.study.folder.outcome(run).unwrap_or_else(refused);
        let results = RunResults::read(&self.study.folder, run, &self.study.columns, outcome);
        self.terminal.event(json!({
            "event": "run", "point": run.point, "seed": run.seed, "values": run.values,
            "status": results.status, "numbers": results.numbers,
            "out": self.study.folder.of_run(run),
        }));
        self.results[index] = Some(results);
        self.write()
    }

    fn write(&self) -> Result<(), StudyError> {
        let Study { folder, contents, columns, runs, .. } = self.study;
        write_tables(folder, contents, columns, runs, &self.results)
    }

    fn tell_failure(&self, index: usize, words: &str) {
        if self.failed > MOST_TOLD {
            return;
        }
        let run = &self.study.runs[index];
        let out = self.study.folder.of_run(run);
        let values = run.words(&self.study.contents);
        let number = format!("run {} of {}", index + 1, self.study.runs.len());
        let text = format!("{number} failed: {values}; outputs in {}\n{words}", out.display());
        self.terminal.point_out(&text);
        self.terminal.event(json!({
            "event": "failure", "point": run.point, "seed": run.seed, "values": run.values,
            "text": words, "out": out,
        }));
    }

    fn show(&mut self) {
        if !self.terminal.wants_progress() {
            return;
        }
        let left = self.waiting.len() + self.going_on.len();
        let each = self.begin.elapsed().as_secs_f64() / self.made as f64;
        self.terminal.progress_of_runs(&RunsProgress {
            ended: self.done(),
            runs: self.results.len(),
            going_on: self.going_on.len(),
            failed: self.failed,
            seconds_left: (self.made > 0).then_some(each * left as f64),
        });
    }
}

/// Text on a run's standard error, its last lines where it is long.
fn words_of(file: &mut File) -> String {
    const LINES: usize = 30;
    let mut bytes = Vec::new();
    let read = file.rewind().and_then(|()| file.read_to_end(&mut bytes));
    if let Err(error) = read {
        return format!("  its words cannot be read: {error}");
    }
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.trim_end().lines().collect();
    let first = lines.len().saturating_sub(LINES);
    lines[first..].iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n")
}
