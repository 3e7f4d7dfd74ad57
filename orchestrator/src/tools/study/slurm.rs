//! Runs of a study on a cluster: arrays of jobs for Slurm, and the collection of their results.
//!
//! The study's folder must be on a file system that the nodes share. Each array has a file of command lines in
//! it, one a task, and a script. `slurm.json` beside the tables names the arrays whose tasks may not have
//! ended, from before Slurm gets them on: a study that was left, or killed at any time, goes on to collect
//! them. Slurm's queue tells the script of each task, by which it is known.
//!
//! A run that was broken off, by a time limit or a node, goes on from its newest checkpoint. If it cannot, for
//! the program is another now, it is given to Slurm once more, from the start.

use super::folder::FolderUse;
use super::results::{StudyEnd, StudyResults, last_words};
use super::threads::ThreadShare;
use super::{Study, StudyError, shell_word};
use crate::terminal::Terminal;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// File of the arrays that may not have ended.
const ARRAYS: &str = "slurm.json";
/// Folder of scripts, command lines and what the tasks say.
const FOLDER: &str = "slurm";
/// Most tasks of an array: clusters allow 1000 as a rule.
const MOST_TASKS: usize = 1000;
/// Time between looks at Slurm's queue.
const LOOK: Duration = Duration::from_secs(2);
/// Time in which the files of a task that has ended must be seen here.
const FILES_SEEN: Duration = Duration::from_secs(10);

/// An array of jobs.
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

/// The runs of a study while a cluster makes them.
pub struct SlurmQueue<'a> {
    study: &'a Study,
    results: StudyResults<'a>,
    interrupts: &'a AtomicUsize,
    /// Most runs at once.
    at_once: Option<usize>,
    arrays: Vec<JobArray>,
    /// Runs that Slurm has, by their numbers: script and task.
    tasks: BTreeMap<usize, Task>,
    /// Runs among them that go on from a checkpoint.
    resumed: BTreeSet<usize>,
    /// When tasks were found to have ended whose files were not seen yet.
    ended: BTreeMap<usize, Instant>,
    /// Numbers of the arrays at Slurm, by their scripts.
    jobs: BTreeMap<PathBuf, String>,
}

impl<'a> SlurmQueue<'a> {
    /// The queue of all runs that are not done.
    pub fn new(
        study: &'a Study,
        jobs: Option<usize>,
        terminal: &'a mut Terminal,
        interrupts: &'a AtomicUsize,
    ) -> Self {
        let results = StudyResults::read(study, terminal);
        // Without it, runs that Slurm has are found by the locks of their folders.
        let text = std::fs::read(study.folder.path().join(ARRAYS)).unwrap_or_default();
        let arrays = serde_json::from_slice(&text).unwrap_or_default();
        Self {
            study,
            results,
            interrupts,
            at_once: jobs,
            arrays,
            tasks: BTreeMap::new(),
            resumed: BTreeSet::new(),
            ended: BTreeMap::new(),
            jobs: BTreeMap::new(),
        }
    }

    /// Submits all runs that are neither done nor at Slurm, and collects the results. After an interrupt the
    /// runs go on at Slurm.
    ///
    /// # Errors
    /// If Slurm refuses, or the study's own files cannot be written.
    pub fn make_all(mut self) -> Result<StudyEnd, StudyError> {
        self.results.write()?;
        self.find_tasks()?;
        self.submit()?;
        let mut looked: Option<Instant> = None;
        while !self.tasks.is_empty() {
            if self.interrupts.load(Ordering::Relaxed) > 0 {
                self.tell_how_it_goes_on();
                return Ok(self.results.end(true));
            }
            if looked.is_none_or(|looked| looked.elapsed() >= LOOK) {
                self.collect()?;
                looked = Some(Instant::now());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(self.results.end(false))
    }

    /// Finds the runs that Slurm has of a study before.
    fn find_tasks(&mut self) -> Result<(), StudyError> {
        if self.arrays.is_empty() {
            return Ok(());
        }
        let queued = queued()?;
        let left: BTreeSet<usize> = self.results.left().collect();
        let name = |index: usize| self.study.runs[index].name.as_str();
        let numbers: BTreeMap<&str, usize> =
            left.iter().map(|index| (name(*index), *index)).collect();
        for JobArray { script, runs, resumed } in &self.arrays {
            for (task, run) in (1..).zip(runs) {
                let task = (script.clone(), task);
                if let Some(index) = numbers.get(run.as_str())
                    && let Some(found) = queued.get(&task)
                {
                    self.jobs.insert(script.clone(), found.job.clone());
                    self.tasks.insert(*index, task);
                    self.resumed.extend(resumed.contains(run).then_some(*index));
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
    fn submit(&mut self) -> Result<(), StudyError> {
        let mut new = Vec::new();
        let left: Vec<usize> = self.results.left().collect();
        for index in left.into_iter().filter(|index| !self.tasks.contains_key(index)) {
            let run = &self.study.runs[index];
            match self.study.folder.use_of(run)? {
                FolderUse::Done => self.results.take(index)?,
                FolderUse::BrokenOff => {
                    self.resumed.insert(index);
                    new.push(index);
                }
                FolderUse::Unfinished => {
                    self.study.folder.remove(run)?;
                    new.push(index);
                }
                FolderUse::Free => new.push(index),
                FolderUse::UnderWay => {
                    let out = self.study.folder.of_run(run);
                    let text =
                        format!("{} is being made by somebody else: left out", out.display());
                    self.results.terminal.point_out(&text);
                }
            }
        }
        self.submit_runs(&new)
    }

    fn submit_runs(&mut self, runs: &[usize]) -> Result<(), StudyError> {
        let is_one_of_several = runs.len() > MOST_TASKS;
        runs.chunks(MOST_TASKS).try_for_each(|array| self.submit_array(array, is_one_of_several))
    }

    /// Command line of a run, which goes on or begins.
    fn line_of(&self, index: usize, share: &ThreadShare) -> Result<String, StudyError> {
        let run = &self.study.runs[index];
        match self.resumed.contains(&index) {
            true => self.study.resuming_line(run),
            false => self.study.command_line(run, share),
        }
    }

    fn submit_array(&mut self, runs: &[usize], is_one_of_several: bool) -> Result<(), StudyError> {
        let folder = self.study.folder.path().join(FOLDER);
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        std::fs::create_dir_all(&folder).map_err(StudyError::io(&folder))?;
        let number = (1..).find(|k| !folder.join(format!("{k}.sh")).exists()).unwrap_or(1);
        let (lines, script) = (format!("{number}.lines"), format!("{number}.sh"));
        let contents = &self.study.contents;
        let shares: Vec<ThreadShare> =
            runs.iter().map(|run| contents.slurm.share(&self.study.runs[*run].threads)).collect();
        let mut text = String::new();
        for (run, share) in runs.iter().zip(&shares) {
            text += &self.line_of(*run, share)?;
            text.push('\n');
        }
        let write = |name: &str, text: &str| {
            let path = folder.join(name);
            std::fs::write(&path, text).map_err(StudyError::io(&path)).map(|()| path)
        };
        let lines = write(&lines, &text)?;
        let array = ArrayScript {
            name: format!("tremie-{}", self.study.name()),
            tasks: runs.len(),
            at_once: self.at_once,
            in_turn: is_one_of_several && self.at_once.is_some(),
            threads: shares.iter().map(|share| share.threads).max().unwrap_or(1),
            folder: folder.clone(),
            options: contents.slurm.options.clone(),
            lines,
        };
        let script = write(&script, &array.text())?;
        let name = |run: &usize| self.study.runs[*run].name.clone();
        let resumed = runs.iter().filter(|run| self.resumed.contains(run)).map(name).collect();
        let names = runs.iter().map(name).collect();
        self.arrays.push(JobArray { script: script.clone(), runs: names, resumed });
        self.note()?;
        let job = run_command(Command::new("sbatch").arg("--parsable").arg(&script))?;
        // With a cluster's name behind it where there are several.
        let job = job.trim().split(';').next().unwrap_or_default().to_string();
        self.tasks.extend((1..).zip(runs).map(|(task, run)| (*run, (script.clone(), task))));
        let text = format!("Slurm has {} runs as job {job}; {}", runs.len(), script.display());
        self.results.terminal.say(&text);
        self.jobs.insert(script, job);
        Ok(())
    }

    /// Takes the results of tasks that have ended.
    fn collect(&mut self) -> Result<(), StudyError> {
        let queued = queued()?;
        let (mut running, mut waiting) = (0, 0);
        let (mut gone, mut anew) = (Vec::new(), Vec::new());
        for (&index, task) in &self.tasks {
            match queued.get(task).map(|found| found.state) {
                Some(TaskState::Waiting) => waiting += 1,
                Some(TaskState::Running) => running += 1,
                None => gone.push(index),
            }
        }
        for index in gone {
            let ended = *self.ended.entry(index).or_insert_with(Instant::now);
            // A shared file system shows files of another machine late.
            let is_seen = self.study.folder.outcome(&self.study.runs[index]).is_some();
            if !is_seen && ended.elapsed() < FILES_SEEN {
                continue;
            }
            let Some((script, task)) = self.tasks.remove(&index) else { continue };
            let job = self.jobs.get(&script).cloned().unwrap_or_default();
            let end = TaskEnd::asked(&job, task);
            if self.resumed.remove(&index) && !self.results.is_done(index) && end.has_failed() {
                // Of another program, or with a state that is damaged: from the start, then.
                self.study.folder.remove(&self.study.runs[index])?;
                anew.push(index);
                continue;
            }
            let file = self.study.folder.path().join(FOLDER).join(format!("{job}_{task}.txt"));
            self.results.take_made(index, || end.words(&file))?;
        }
        self.forget_ended()?;
        self.submit_runs(&anew)?;
        self.results.show(running, waiting);
        Ok(())
    }

    /// Scripts of the arrays that have tasks which may not have ended.
    fn scripts(&self) -> BTreeSet<&PathBuf> {
        self.tasks.values().map(|(script, _)| script).collect()
    }

    /// Forgets arrays all of whose tasks have ended.
    fn forget_ended(&mut self) -> Result<(), StudyError> {
        let scripts = self.scripts();
        let is_over = |array: &JobArray| !scripts.contains(&array.script);
        if !self.arrays.iter().any(is_over) {
            return Ok(());
        }
        let left = self.arrays.iter().filter(|array| !is_over(array)).cloned().collect();
        self.arrays = left;
        self.note()
    }

    /// Notes the arrays that may not have ended.
    fn note(&self) -> Result<(), StudyError> {
        let text = serde_json::to_vec_pretty(&self.arrays).unwrap_or_default();
        self.study.folder.write(ARRAYS, &text)
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
        // Slurm takes the quotes off; without them a name ends at its first space.
        let quoted = |text: String| shell_word(OsStr::new(&text));
        let mut options = vec![
            format!("--job-name={}", quoted(self.name.clone())),
            format!("--array=1-{}{at_once}", self.tasks),
            format!("--cpus-per-task={}", self.threads),
            format!("--output={}", quoted(format!("{}/%A_%a.txt", self.folder.display()))),
            // With a run that was broken off the next study goes on, as it can.
            "--no-requeue".into(),
        ];
        options.extend(self.in_turn.then(|| "--dependency=singleton".into()));
        // Last: they hold where an option stands twice.
        options.extend(self.options.iter().cloned());
        let options =
            options.iter().map(|option| format!("#SBATCH {option}\n")).collect::<String>();
        let lines = shell_word(self.lines.as_os_str());
        format!(
            "#!/bin/sh\n{options}\n# Command line of this task. `exec`: signals reach the run.\n\
             eval \"exec $(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {lines})\"\n"
        )
    }
}

/// State of a task in Slurm's queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TaskState {
    Waiting,
    Running,
}

/// A task as Slurm's queue has it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct QueuedTask {
    /// Number of its array.
    job: String,
    state: TaskState,
}

/// All of the user's tasks that have not ended.
fn queued() -> Result<BTreeMap<Task, QueuedTask>, StudyError> {
    let arguments = ["--me", "--array", "--noheader", "--format=%F %K %T %o"];
    let text = run_command(Command::new("squeue").args(arguments))?;
    Ok(text.lines().filter_map(task_of_line).collect())
}

/// A line of the queue: job, task, state and script; `None` for what is no task of an array.
fn task_of_line(line: &str) -> Option<(Task, QueuedTask)> {
    let mut words = line.splitn(4, ' ');
    let (job, task, state) = (words.next()?, words.next()?.parse().ok()?, words.next()?);
    let script = words.next()?.trim_end().into();
    let is_running = matches!(state, "RUNNING" | "COMPLETING" | "SUSPENDED" | "STAGE_OUT");
    let state = if is_running { TaskState::Running } else { TaskState::Waiting };
    Some(((script, task), QueuedTask { job: job.to_string(), state }))
}

/// What Slurm says of a task that has ended, as long as it remembers.
struct TaskEnd {
    /// Array and number, as Slurm writes them.
    task: String,
    /// Its word and the exit code.
    state: Option<[String; 2]>,
}

impl TaskEnd {
    /// Asks Slurm.
    fn asked(job: &str, task: usize) -> Self {
        let task = format!("{job}_{task}");
        let mut command = Command::new("scontrol");
        command.args(["--oneliner", "show", "job", &task]).stdin(Stdio::null());
        let told = command.output().map(|output| output.stdout).unwrap_or_default();
        let told = String::from_utf8_lossy(&told);
        let of = |key: &str| {
            told.split_whitespace().find_map(|word| word.strip_prefix(key)).map(String::from)
        };
        let state = of("JobState=").zip(of("ExitCode=")).map(|(state, code)| [state, code]);
        Self { task, state }
    }

    /// True if the program ended by itself, and not well; a limit or a user did not end it.
    fn has_failed(&self) -> bool {
        self.state.as_ref().is_some_and(|[state, _]| state == "FAILED")
    }

    /// Slurm's word, and the last that the task wrote to a file.
    fn words(&self, file: &std::path::Path) -> String {
        let task = &self.task;
        let slurm = match &self.state {
            Some([state, code]) => format!("  Slurm: job {task} {state}, exit code {code}"),
            None => format!("  Slurm: job {task} has ended"),
        };
        let said = File::open(file).map(|mut file| last_words(&mut file)).unwrap_or_default();
        if said.is_empty() { slurm } else { format!("{slurm}\n{said}") }
    }
}

/// Output of one of Slurm's commands.
fn run_command(command: &mut Command) -> Result<String, StudyError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let failed = |message: String| StudyError::Slurm { command: name.clone(), message };
    let output =
        command.stdin(Stdio::null()).output().map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(failed(format!("{}; {}", said.trim(), output.status)))
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

    #[test]
    fn tasks_are_read_from_the_queue() {
        let task = |line| task_of_line(line);
        let found = |job: &str, number, state| {
            Some((("/a b/1.sh".into(), number), QueuedTask { job: job.into(), state }))
        };
        assert_eq!(task("17 3 RUNNING /a b/1.sh"), found("17", 3, TaskState::Running));
        assert_eq!(task("17 4 PENDING /a b/1.sh"), found("17", 4, TaskState::Waiting));
        assert_eq!(task("18 N/A RUNNING /a b/1.sh"), None);
        assert_eq!(task(""), None);
    }
}
