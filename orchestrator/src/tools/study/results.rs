//! Results of the runs of studies as they come, with what the user is told of them.

use super::folder::{FolderUse, RunOutcome};
use super::runs::StudyRun;
use super::shared_runs::{RunPlace, SharedRuns};
use super::table::{RunResults, write_tables};
use super::{Study, StudyError};
use crate::terminal::{RunsProgress, Terminal};
use crate::tools::last_lines::last_lines;
use serde_json::json;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{ErrorKind, Seek};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

/// Most failures that are told in full.
const MOST_TOLD: usize = 20;

/// Results of studies while their runs are made.
pub struct StudyResults<'a> {
    pub studies: &'a [Study],
    pub terminal: &'a mut Terminal,
    interrupts: &'a AtomicUsize,
    /// What has become of each study so far.
    ends: Vec<StudyEnd>,
    shared: SharedRuns,
    /// Runs that a cluster had before; they come to their ends there.
    under_way: BTreeSet<RunPlace>,
    /// Failures that were told.
    told: usize,
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
}

impl StudyEnd {
    /// That of a study none of whose runs is made now.
    fn before(study: &Study) -> Self {
        let of_done = |run| {
            let outcome = study.folder.outcome(run).filter(RunOutcome::is_done)?;
            Some(RunResults::read(&study.folder, run, &study.columns, outcome))
        };
        Self { results: study.runs.iter().map(of_done).collect(), made: 0, failed: 0 }
    }

    /// Runs that have ended.
    pub fn ended(&self) -> usize {
        self.results.iter().flatten().count()
    }
}

impl<'a> StudyResults<'a> {
    /// Results of the runs that are done already.
    pub fn read(
        studies: &'a [Study],
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
    ) -> Self {
        let ends = studies.iter().map(StudyEnd::before).collect();
        let (shared, under_way, told) = (SharedRuns::default(), BTreeSet::new(), 0);
        let begin = Instant::now();
        Self { studies, terminal, interrupts, ends, shared, under_way, told, begin }
    }

    /// Writes all tables, and returns the runs to be made. A cluster has those at `under_way`. Studies get
    /// copies of runs that others have done; after an interrupt no more of them.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn begin(&mut self, under_way: BTreeSet<RunPlace>) -> Result<Vec<RunPlace>, StudyError> {
        (0..self.studies.len()).try_for_each(|study| self.write(study))?;
        self.shared = SharedRuns::of(self.studies, &under_way)?;
        self.under_way = under_way;
        let mut left = self.not_ended();
        left.retain(|place| !self.shared.is_copy(*place) && !self.under_way.contains(place));
        let done: Vec<_> = self.shared.made_at().filter(|place| self.has(*place)).collect();
        for place in done {
            left.extend(self.hand_on(place)?);
        }
        left.sort_unstable();
        Ok(left)
    }

    /// A run's study.
    pub fn study(&self, place: RunPlace) -> &'a Study {
        &self.studies[place.study]
    }

    /// A run.
    pub fn run(&self, place: RunPlace) -> &'a StudyRun {
        &self.study(place).runs[place.run]
    }

    /// Readiness of a run's folder.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn use_of(&self, place: RunPlace) -> Result<FolderUse, StudyError> {
        self.study(place).folder.use_of(self.run(place))
    }

    /// Removes the folder of a run.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn remove(&self, place: RunPlace) -> Result<(), StudyError> {
        self.study(place).folder.remove(self.run(place))
    }

    /// The runs that have not ended.
    pub fn not_ended(&self) -> Vec<RunPlace> {
        RunPlace::all(self.studies).filter(|place| !self.has(*place)).collect()
    }

    /// True if the results of a run are here.
    fn has(&self, place: RunPlace) -> bool {
        self.ends[place.study].results[place.run].is_some()
    }

    /// True if a run is done, as its folder tells.
    pub fn is_done(&self, place: RunPlace) -> bool {
        self.outcome(place).is_done()
    }

    /// Takes the results of a run that was made now, as [`Self::take`]; `words` are told if it failed.
    ///
    /// # Errors
    /// If the disk refuses the tables.
    pub fn take_made(
        &mut self,
        place: RunPlace,
        words: impl FnOnce() -> String,
    ) -> Result<Vec<RunPlace>, StudyError> {
        self.ends[place.study].made += 1;
        if !self.is_done(place) {
            self.ends[place.study].failed += 1;
            self.tell_failure(place, &words());
        }
        self.take(place)
    }

    /// Takes the results of a run, also for the studies that get a copy of it, and writes their tables anew.
    /// Returns the runs among those that cannot be copied: they have to be made.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn take(&mut self, place: RunPlace) -> Result<Vec<RunPlace>, StudyError> {
        self.note(place, self.outcome(place))?;
        self.hand_on(place)
    }

    /// Takes the results of a run for the other studies that have it.
    fn hand_on(&mut self, made_at: RunPlace) -> Result<Vec<RunPlace>, StudyError> {
        let outcome = self.outcome(made_at);
        let from = self.study(made_at).folder.of_run(self.run(made_at));
        let mut left = Vec::new();
        for place in self.shared.copies_of(made_at).to_vec() {
            if self.has(place) || self.under_way.contains(&place) {
                continue;
            }
            match self.use_of(place)? {
                // Somebody else has made it meanwhile.
                FolderUse::Done => self.note(place, self.outcome(place))?,
                FolderUse::UnderWay => left.push(place),
                _ if outcome.is_done() => {
                    if self.copy(place, &from)? {
                        self.note(place, outcome.clone())?;
                    } else if self.interrupts.load(Ordering::Relaxed) == 0 {
                        left.push(place);
                    }
                }
                // It was ended from outside: the next study goes on with it.
                _ if outcome.status == "interrupted" => {}
                // It would fail as well. What is in its folder stays.
                _ => {
                    self.ends[place.study].failed += 1;
                    self.note(place, outcome.clone())?;
                }
            }
        }
        Ok(left)
    }

    /// Copies a run from another study; false if it cannot be copied, and has to be made.
    fn copy(&mut self, place: RunPlace, from: &Path) -> Result<bool, StudyError> {
        let folder = &self.study(place).folder;
        let to = folder.of_run(self.run(place));
        let (to, from_text) = (to.display(), from.display());
        self.terminal.say(&format!("{to} is copied from {from_text}"));
        match folder.copy_run(self.run(place), from, self.interrupts) {
            Ok(is_copied) => Ok(is_copied),
            Err(StudyError::Interrupted) => Ok(false),
            // A run would fail there, after hours.
            Err(StudyError::Io { path, error }) if error.kind() == ErrorKind::StorageFull => {
                Err(StudyError::Io { path, error })
            }
            Err(error) => {
                self.terminal.warn(&format!("{error}: {to} is made anew"));
                Ok(false)
            }
        }
    }

    fn outcome(&self, place: RunPlace) -> RunOutcome {
        // A run that the manifest's components refuse has no summary.
        let refused = || RunOutcome { status: "failed".into(), wall_time: None };
        self.study(place).folder.outcome(self.run(place)).unwrap_or_else(refused)
    }

    fn note(&mut self, place: RunPlace, outcome: RunOutcome) -> Result<(), StudyError> {
        let (study, run) = (self.study(place), self.run(place));
        let results = RunResults::read(&study.folder, run, &study.columns, outcome);
        self.terminal.event(json!({
            "event": "run", "point": run.point, "seed": run.seed, "values": run.values,
            "status": results.status, "numbers": results.numbers,
            "out": study.folder.of_run(run),
        }));
        self.ends[place.study].results[place.run] = Some(results);
        self.write(place.study)
    }

    /// Writes the tables of a study.
    fn write(&self, study: usize) -> Result<(), StudyError> {
        let Study { folder, contents, columns, runs, .. } = &self.studies[study];
        write_tables(folder, contents, columns, runs, &self.ends[study].results)
    }

    /// Tells that a run is left to another program.
    pub fn tell_left_out(&self, place: RunPlace) {
        let out = self.study(place).folder.of_run(self.run(place));
        let text = format!("{} is being made by somebody else: left out", out.display());
        self.terminal.point_out(&text);
    }

    fn tell_failure(&mut self, place: RunPlace, words: &str) {
        self.told += 1;
        if self.told > MOST_TOLD {
            return;
        }
        let (study, run) = (self.study(place), self.run(place));
        let out = study.folder.of_run(run);
        let values = run.words(&study.contents);
        let name =
            if self.studies.len() > 1 { format!(" of {}", study.name()) } else { String::new() };
        let number = format!("run {} of {}{name}", place.run + 1, study.runs.len());
        let copies = self.shared.copies_of(place).iter();
        let also = |place: &RunPlace| format!(", also in {}", self.study(*place).name());
        let also: String = copies.map(also).collect();
        let text =
            format!("{number} failed{also}: {values}; outputs in {}\n{words}", out.display());
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
        let made: usize = self.ends.iter().map(|end| end.made).sum();
        let each = self.begin.elapsed().as_secs_f64() / made as f64;
        let failed = self.ends.iter().map(|end| end.failed).sum();
        self.terminal.progress_of_runs(&RunsProgress {
            ended: self.ends.iter().map(StudyEnd::ended).sum(),
            runs: self.studies.iter().map(|study| study.runs.len()).sum(),
            going_on,
            failed,
            seconds_left: (made > 0).then_some(each * (waiting + going_on) as f64),
        });
    }

    /// What became of each study.
    pub fn end(self) -> Vec<StudyEnd> {
        self.ends
    }
}

/// Text in a file, its last lines where it is long.
pub fn last_words(file: &mut File) -> String {
    match file.rewind().and_then(|()| last_lines(file)) {
        Ok(lines) => lines.iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n"),
        Err(error) => format!("  its words cannot be read: {error}"),
    }
}
