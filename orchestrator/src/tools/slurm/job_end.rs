//! Ends of jobs: Slurm's word on them, and what they wrote.

use crate::tools::last_lines::last_lines;
use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Time in which the files of a job that has ended must be seen: a shared file system shows those of another
/// machine late.
pub const FILES_SEEN: Duration = Duration::from_secs(10);

/// What Slurm says of a job that has ended, as long as it remembers.
pub struct JobEnd {
    /// Its number, with that of the task of an array, as Slurm writes them.
    job: String,
    /// Slurm's word and the exit code.
    state: Option<[String; 2]>,
}

impl JobEnd {
    /// Asks Slurm.
    pub fn asked(job: String) -> Self {
        let mut command = Command::new("scontrol");
        command.args(["--oneliner", "show", "job", &job]).stdin(Stdio::null());
        let told = command.output().map(|output| output.stdout).unwrap_or_default();
        let told = String::from_utf8_lossy(&told);
        let of = |key: &str| {
            told.split_whitespace().find_map(|word| word.strip_prefix(key)).map(String::from)
        };
        let state = of("JobState=").zip(of("ExitCode=")).map(|(state, code)| [state, code]);
        Self { job, state }
    }

    /// True if the program ended by itself, and not well; a limit or a user did not end it.
    pub fn has_failed(&self) -> bool {
        self.is("FAILED")
    }

    /// True if the program ended by itself, and well.
    pub fn is_completed(&self) -> bool {
        self.is("COMPLETED")
    }

    fn is(&self, word: &str) -> bool {
        self.state.as_ref().is_some_and(|[state, _]| state == word)
    }

    /// Slurm's word.
    pub fn word(&self) -> String {
        let job = &self.job;
        match &self.state {
            Some([state, code]) => format!("Slurm: job {job} {state}, exit code {code}"),
            None => format!("Slurm: job {job} has ended"),
        }
    }

    /// Slurm's word, and the last that the job wrote to a file; indented.
    pub fn words(&self, file: &Path) -> String {
        let said = last_words(file).into_iter().map(|line| format!("\n  {line}"));
        format!("  {}{}", self.word(), said.collect::<String>())
    }
}

/// The last lines that a job wrote to a file; none if it has not begun.
pub(super) fn last_words(file: &Path) -> Vec<String> {
    File::open(file).and_then(|mut file| last_lines(&mut file)).unwrap_or_default()
}
