//! Runs of studies on a cluster: arrays of jobs for Slurm, and the collection of their results.
//!
//! A study's folder must be on a file system that the nodes share. Each array has a file of command lines in
//! it, one a task, and a script. `slurm.json` beside the tables names the arrays whose tasks may not have
//! ended, from before Slurm gets them on: a study that was left, or killed at any time, goes on to collect
//! them. Slurm's queue tells the script of each task, by which it is known.
//!
//! A run that was broken off, by a time limit or a node, goes on from its newest checkpoint. If it cannot, for
//! the program is another now, it is given to Slurm once more, from the start.

use super::folder::FolderUse;
use super::results::{StudyEnd, StudyResults};
use super::shared_runs::RunPlace;
use super::threads::ThreadShare;
use super::{Study, StudyError};
use crate::outputs::SLURM;
use crate::terminal::Terminal;
use crate::tools::shell::shell_word;
use crate::tools::slurm::{
    FILES_SEEN, JobEnd, JobState, QueuedJob, option_lines, queued, quoted, submit,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// File of the arrays that may not have ended.
const ARRAYS: &str = "slurm.json";
/// Most tasks of an array: clusters allow 1000 as a rule.
const MOST_TASKS: usize = 1000;
/// Time between looks at Slurm's queue.
const LOOK: Duration = Duration::from_secs(2);

/// An array of jobs, for runs of one study.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct JobArray {
    /// Its script, by which it is known at Slurm.
    script: PathBuf,
    /// Names of the runs of its tasks, from task 1 on.
    runs: Vec<String>,
    /// Those of them that go on from a checkpoint.
    #[serde(default)]
    resumed: BTreeSet<String>,
}

/// A task: the script of its array, and its number there.
type Task = (PathBuf, usize);

/// The runs of studies while a cluster makes them.
pub struct SlurmQueue<'a> {
    results: StudyResults<'a>,
    interrupts: &'a AtomicUsize,
    /// Most runs of a study at once.
    at_once: Option<usize>,
    /// Arrays of each study.
    arrays: Vec<Vec<JobArray>>,
    /// Runs that Slurm has: script and task of each.
    tasks: BTreeMap<RunPlace, Task>,
    /// Runs among them that go on from a checkpoint.
    resumed: BTreeSet<RunPlace>,
    /// When tasks were found to have ended whose files were not seen yet.
    ended: BTreeMap<RunPlace, Instant>,
    /// Numbers of the arrays at Slurm, by their scripts.
    jobs: BTreeMap<PathBuf, String>,
}

impl<'a> SlurmQueue<'a> {
    /// The queue of all runs that are not done.
    pub fn new(
        studies: &'a [Study],
        jobs: Option<usize>,
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
    ) -> Self {
        let noted = |study: &Study| {
            // Without it, runs that Slurm has are found by the locks of their folders.
            let text = std::fs::read(study.folder.path().join(ARRAYS)).unwrap_or_default();
            serde_json::from_slice(&text).unwrap_or_default()
        };
        Self {
            results: StudyResults::read(studies, terminal, interrupts),
            interrupts,
            at_once: jobs,
            arrays: studies.iter().map(noted).collect(),
            tasks: BTreeMap::new(),
            resumed: BTreeSet::new(),
            ended: BTreeMap::new(),
            jobs: BTreeMap::new(),
        }
    }

    /// Submits all runs that are neither done nor at Slurm, and collects the results: what became of each
    /// study. After an interrupt the runs go on at Slurm.
    ///
    /// # Errors
    /// If Slurm refuses, or the studies' own files cannot be written.
    pub fn make_all(mut self) -> Result<Vec<StudyEnd>, StudyError> {
        self.find_tasks()?;
        let at_slurm = self.tasks.keys().copied().collect();
        let left = self.results.begin(at_slurm)?;
        if self.interrupts.load(Ordering::Relaxed) == 0 {
            self.submit(left)?;
        }
        let mut looked: Option<Instant> = None;
        while !self.tasks.is_empty() {
            if self.interrupts.load(Ordering::Relaxed) > 0 {
                self.tell_how_it_goes_on();
                break;
            }
            if looked.is_none_or(|looked| looked.elapsed() >= LOOK) {
                self.collect()?;
                looked = Some(Instant::now());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(self.results.end())
    }

    /// Finds the runs that Slurm has from before.
    fn find_tasks(&mut self) -> Result<(), StudyError> {
        if self.arrays.iter().all(Vec::is_empty) {
            return Ok(());
        }
        let queued = queued_tasks()?;
        let not_ended = self.results.not_ended();
        let name = |place: &RunPlace| (place.study, self.results.run(*place).name.as_str());
        let places: BTreeMap<(usize, &str), RunPlace> =
            not_ended.iter().map(|place| (name(place), *place)).collect();
        let of_study = |(study, arrays)| std::iter::repeat(study).zip(arrays);
        for (study, JobArray { script, runs, resumed }) in
            self.arrays.iter().enumerate().flat_map(of_study)
        {
            for (task, run) in (1..).zip(runs) {
                let task = (script.clone(), task);
                if let Some(place) = places.get(&(study, run.as_str()))
                    && let Some(found) = queued.get(&task)
                {
                    self.jobs.insert(script.clone(), found.job.clone());
                    self.tasks.insert(*place, task);
                    self.resumed.extend(resumed.contains(run).then_some(*place));
                }
            }
        }
        let found = self.tasks.len();
        if found > 0 {
            self.results.terminal.say(&format!("Slurm has {found} of the runs already"));
        }
        self.forget_ended()
    }

    /// Submits what is neither done nor at Slurm.
    fn submit(&mut self, mut left: Vec<RunPlace>) -> Result<(), StudyError> {
        let mut new = Vec::new();
        while let Some(place) = left.pop() {
            match self.results.use_of(place)? {
                FolderUse::Done => left.extend(self.results.take(place)?),
                FolderUse::BrokenOff => {
                    self.resumed.insert(place);
                    new.push(place);
                }
                FolderUse::Unfinished => {
                    self.results.remove(place)?;
                    new.push(place);
                }
                FolderUse::Free => new.push(place),
                FolderUse::UnderWay => self.results.tell_left_out(place),
            }
        }
        new.sort_unstable();
        self.submit_runs(&new)
    }

    /// Submits runs, sorted by their studies.
    fn submit_runs(&mut self, runs: &[RunPlace]) -> Result<(), StudyError> {
        let of_studies = runs.chunk_by(|one, next| one.study == next.study);
        for (study, runs) in of_studies.filter_map(|runs| Some((runs.first()?.study, runs))) {
            let is_one_of_several = runs.len() > MOST_TASKS;
            runs.chunks(MOST_TASKS)
                .try_for_each(|array| self.submit_array(study, array, is_one_of_several))?;
        }
        Ok(())
    }

    /// Command line of a run, which goes on or begins.
    fn line_of(&self, place: RunPlace, share: &ThreadShare) -> Result<String, StudyError> {
        let (study, run) = (self.results.study(place), self.results.run(place));
        match self.resumed.contains(&place) {
            true => study.resuming_line(run, share),
            false => study.command_line(run, share),
        }
    }

    fn submit_array(
        &mut self,
        study: usize,
        runs: &[RunPlace],
        is_one_of_several: bool,
    ) -> Result<(), StudyError> {
        let Study { folder, contents, .. } = &self.results.studies[study];
        let scripts = folder.path().join(SLURM);
        let scripts = std::path::absolute(&scripts).unwrap_or(scripts);
        std::fs::create_dir_all(&scripts).map_err(StudyError::io(&scripts))?;
        let number = (1..).find(|k| !scripts.join(format!("{k}.sh")).exists()).unwrap_or(1);
        let (lines, script) = (format!("{number}.lines"), format!("{number}.sh"));
        let share = |place: &RunPlace| contents.slurm.share(&self.results.run(*place).threads);
        let shares: Vec<ThreadShare> = runs.iter().map(share).collect();
        let mut text = String::new();
        for (place, share) in runs.iter().zip(&shares) {
            text += &self.line_of(*place, share)?;
            text.push('\n');
        }
        let write = |name: &str, text: &str| {
            let path = scripts.join(name);
            std::fs::write(&path, text).map_err(StudyError::io(&path)).map(|()| path)
        };
        let lines = write(&lines, &text)?;
        let array = ArrayScript {
            name: format!("tremie-{}", self.results.studies[study].name()),
            tasks: runs.len(),
            at_once: self.at_once,
            in_turn: is_one_of_several && self.at_once.is_some(),
            threads: shares.iter().map(|share| share.threads).max().unwrap_or(1),
            folder: scripts.clone(),
            options: contents.slurm.options.clone(),
            lines,
        };
        let script = write(&script, &array.text())?;
        let name = |place: &RunPlace| self.results.run(*place).name.clone();
        let resumed = runs.iter().filter(|run| self.resumed.contains(run)).map(name).collect();
        let names = runs.iter().map(name).collect();
        self.arrays[study].push(JobArray { script: script.clone(), runs: names, resumed });
        self.note(study)?;
        let job = submit(&script)?;
        self.tasks.extend((1..).zip(runs).map(|(task, place)| (*place, (script.clone(), task))));
        let text = format!("Slurm has {} runs as job {job}; {}", runs.len(), script.display());
        self.results.terminal.say(&text);
        self.jobs.insert(script, job);
        Ok(())
    }

    /// Takes the results of tasks that have ended.
    fn collect(&mut self) -> Result<(), StudyError> {
        let queued = queued_tasks()?;
        let (mut running, mut waiting) = (0, 0);
        let (mut gone, mut left) = (Vec::new(), Vec::new());
        for (&place, task) in &self.tasks {
            match queued.get(task).map(|found| found.state) {
                Some(JobState::Waiting) => waiting += 1,
                Some(JobState::Running) => running += 1,
                None => gone.push(place),
            }
        }
        for place in gone {
            let ended = *self.ended.entry(place).or_insert_with(Instant::now);
            let folder = &self.results.study(place).folder;
            // A shared file system shows files of another machine late.
            let is_seen = folder.outcome(self.results.run(place)).is_some();
            if !is_seen && ended.elapsed() < FILES_SEEN {
                continue;
            }
            self.ended.remove(&place);
            let Some((script, task)) = self.tasks.remove(&place) else { continue };
            let job = self.jobs.get(&script).cloned().unwrap_or_default();
            let end = JobEnd::asked(format!("{job}_{task}"));
            if self.resumed.remove(&place) && !self.results.is_done(place) && end.has_failed() {
                // Of another program, or with a state that is damaged: from the start, then.
                self.results.remove(place)?;
                left.push(place);
                continue;
            }
            let file = folder.path().join(SLURM).join(format!("{job}_{task}.txt"));
            left.extend(self.results.take_made(place, || end.words(&file))?);
        }
        self.forget_ended()?;
        self.submit(left)?;
        self.results.show(running, waiting);
        Ok(())
    }

    /// Scripts of the arrays that have tasks which may not have ended.
    fn scripts(&self) -> BTreeSet<&PathBuf> {
        self.tasks.values().map(|(script, _)| script).collect()
    }

    /// Forgets arrays all of whose tasks have ended.
    fn forget_ended(&mut self) -> Result<(), StudyError> {
        let scripts: BTreeSet<PathBuf> = self.scripts().into_iter().cloned().collect();
        for study in 0..self.arrays.len() {
            let before = self.arrays[study].len();
            self.arrays[study].retain(|array| scripts.contains(&array.script));
            if self.arrays[study].len() < before {
                self.note(study)?;
            }
        }
        Ok(())
    }

    /// Notes the arrays of a study that may not have ended.
    fn note(&self, study: usize) -> Result<(), StudyError> {
        let text = serde_json::to_vec_pretty(&self.arrays[study]).unwrap_or_default();
        self.results.studies[study].folder.write(ARRAYS, &text)
    }

    fn tell_how_it_goes_on(&self) {
        let jobs = self.scripts().into_iter().filter_map(|script| self.jobs.get(script));
        let jobs = jobs.map(String::as_str).collect::<Vec<_>>().join(" ");
        let text = format!(
            "{} runs go on at Slurm; `scancel {jobs}` ends them, the same command collects them",
            self.tasks.len()
        );
        self.results.terminal.say(&text);
    }
}

/// The script of an array.
struct ArrayScript {
    name: String,
    tasks: usize,
    at_once: Option<usize>,
    /// The array begins when the one before has ended.
    in_turn: bool,
    threads: u32,
    folder: PathBuf,
    options: Vec<String>,
    /// File of the command lines.
    lines: PathBuf,
}

impl ArrayScript {
    fn text(&self) -> String {
        let at_once = self.at_once.map_or(String::new(), |jobs| format!("%{jobs}"));
        let mut options = vec![
            format!("--job-name={}", quoted(&self.name)),
            format!("--array=1-{}{at_once}", self.tasks),
            format!("--cpus-per-task={}", self.threads),
            format!("--output={}", quoted(&format!("{}/%A_%a.txt", self.folder.display()))),
            // With a run that was broken off the next study goes on, as it can.
            "--no-requeue".into(),
        ];
        options.extend(self.in_turn.then(|| "--dependency=singleton".into()));
        // Last: they hold where an option stands twice.
        options.extend(self.options.iter().cloned());
        let options = option_lines(&options);
        let lines = shell_word(self.lines.as_os_str());
        format!(
            "#!/bin/sh\n{options}\n# Command line of this task. `exec`: signals reach the run.\n\
             eval \"exec $(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {lines})\"\n"
        )
    }
}

/// All of the user's tasks of arrays that have not ended.
fn queued_tasks() -> Result<BTreeMap<Task, QueuedJob>, StudyError> {
    let task = |queued: QueuedJob| Some(((queued.script.clone(), queued.task?), queued));
    Ok(queued()?.into_iter().filter_map(task).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_asks_for_what_the_runs_need() {
        let mut array = ArrayScript {
            name: "tremie-pistons".into(),
            tasks: 12,
            at_once: Some(3),
            in_turn: false,
            threads: 4,
            folder: "/home/a b/slurm".into(),
            options: vec!["--time=1:00:00".into()],
            lines: "/home/a b/slurm/1.lines".into(),
        };
        let text = array.text();
        for line in [
            "#!/bin/sh",
            "#SBATCH --array=1-12%3",
            "#SBATCH --cpus-per-task=4",
            "#SBATCH --output='/home/a b/slurm/%A_%a.txt'",
            "#SBATCH --time=1:00:00",
            "eval \"exec $(sed -n \"${SLURM_ARRAY_TASK_ID}p\" '/home/a b/slurm/1.lines')\"",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
        assert!(!text.contains("singleton"));
        (array.at_once, array.in_turn) = (None, true);
        assert!(array.text().contains("--array=1-12\n") && array.text().contains("singleton"));
    }
}
