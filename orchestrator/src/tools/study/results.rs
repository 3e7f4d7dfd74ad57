//! Results of a study's runs as they come, with what the user is told of them.

use super::folder::RunOutcome;
use super::table::{RunResults, write_tables};
use super::{Study, StudyError};
use crate::terminal::{RunsProgress, Terminal};
use crate::tools::last_lines::last_lines;
use serde_json::json;
use std::fs::File;
use std::io::Seek;
use std::time::Instant;

/// Most failures that are told in full.
const MOST_TOLD: usize = 20;

/// Results of a study while its runs are made.
pub struct StudyResults<'a> {
    pub study: &'a Study,
    pub terminal: &'a mut Terminal,
    /// Results of the runs that have ended.
    results: Vec<Option<RunResults>>,
    /// Runs that this study made.
    made: usize,
    failed: usize,
    begin: Instant,
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

impl<'a> StudyResults<'a> {
    /// Results of the runs that are done already.
    pub fn read(study: &'a Study, terminal: &'a mut Terminal) -> Self {
        let of_done = |run| {
            let outcome = study.folder.outcome(run).filter(RunOutcome::is_done)?;
            Some(RunResults::read(&study.folder, run, &study.columns, outcome))
        };
        let results = study.runs.iter().map(of_done).collect();
        Self { study, terminal, results, made: 0, failed: 0, begin: Instant::now() }
    }

    /// Numbers of the runs that have not ended.
    pub fn left(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.results.len()).filter(|index| self.results[*index].is_none())
    }

    /// True if a run is done, as its folder tells.
    pub fn is_done(&self, index: usize) -> bool {
        let outcome = self.study.folder.outcome(&self.study.runs[index]);
        outcome.is_some_and(|outcome| outcome.is_done())
    }

    /// Takes the results of a run that this study made; `words` are told if it failed.
    ///
    /// # Errors
    /// If the disk refuses the tables.
    pub fn take_made(
        &mut self,
        index: usize,
        words: impl FnOnce() -> String,
    ) -> Result<(), StudyError> {
        self.made += 1;
        if !self.is_done(index) {
            self.failed += 1;
            self.tell_failure(index, &words());
        }
        self.take(index)
    }

    /// Takes the results of a run, and writes the tables anew.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn take(&mut self, index: usize) -> Result<(), StudyError> {
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

    /// Writes the tables.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn write(&self) -> Result<(), StudyError> {
        let Study { folder, contents, columns, runs, .. } = self.study;
        write_tables(folder, contents, columns, runs, &self.results)
    }

    fn tell_failure(&mut self, index: usize, words: &str) {
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

    /// Shows progress, with so many runs under way and so many that wait.
    pub fn show(&mut self, going_on: usize, waiting: usize) {
        if !self.terminal.wants_progress() {
            return;
        }
        let each = self.begin.elapsed().as_secs_f64() / self.made as f64;
        self.terminal.progress_of_runs(&RunsProgress {
            ended: self.results.iter().flatten().count(),
            runs: self.results.len(),
            going_on,
            failed: self.failed,
            seconds_left: (self.made > 0).then_some(each * (waiting + going_on) as f64),
        });
    }

    /// What became of all runs.
    pub fn end(self, is_interrupted: bool) -> StudyEnd {
        let Self { results, made, failed, .. } = self;
        StudyEnd { results, made, failed, is_interrupted }
    }
}

/// Text in a file, its last lines where it is long.
pub fn last_words(file: &mut File) -> String {
    match file.rewind().and_then(|()| last_lines(file)) {
        Ok(lines) => lines.iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n"),
        Err(error) => format!("  its words cannot be read: {error}"),
    }
}
