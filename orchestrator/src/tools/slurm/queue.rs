//! Slurm's queue.

use super::call::{SlurmError, output_of};
use std::path::PathBuf;
use std::process::Command;

/// State of a job, or of a task of an array, in Slurm's queue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobState {
    /// It has not begun.
    Waiting,
    /// It has begun, and has not ended.
    Running,
}

/// A job, or a task of an array, as Slurm's queue has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QueuedJob {
    /// Number of the job.
    pub job: String,
    /// Number of the task, of an array.
    pub task: Option<usize>,
    /// Its state.
    pub state: JobState,
    /// Its nodes, as Slurm writes them; empty before it runs.
    pub nodes: String,
    /// Why it waits, in Slurm's word.
    pub reason: String,
    /// Its script, as `sbatch` was given it.
    pub script: PathBuf,
}

/// All of the user's jobs that have not ended.
///
/// # Errors
/// What `squeue` says.
pub fn queued() -> Result<Vec<QueuedJob>, SlurmError> {
    let arguments = ["--me", "--array", "--noheader", "--format=%F|%K|%T|%N|%r|%o"];
    let text = output_of(Command::new("squeue").args(arguments))?;
    Ok(text.lines().filter_map(job_of_line).collect())
}

/// A line of the queue; `None` for what is none.
fn job_of_line(line: &str) -> Option<QueuedJob> {
    let mut words = line.splitn(6, '|');
    let job = words.next()?.to_string();
    let task = words.next()?.parse().ok();
    let is_running = matches!(words.next()?, "RUNNING" | "COMPLETING" | "SUSPENDED" | "STAGE_OUT");
    let state = if is_running { JobState::Running } else { JobState::Waiting };
    let (nodes, reason) = (words.next()?.into(), words.next()?.into());
    let script = words.next()?.trim_end().into();
    Some(QueuedJob { job, task, state, nodes, reason, script })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_read_from_the_queue() {
        let job = job_of_line("17|3|RUNNING|n1|None|/a b/1.sh").unwrap();
        assert_eq!((job.job.as_str(), job.task, job.nodes.as_str()), ("17", Some(3), "n1"));
        assert_eq!((job.state, job.script), (JobState::Running, "/a b/1.sh".into()));
        let job = job_of_line("18|N/A|PENDING||Nodes required, down|/a|b.sh ").unwrap();
        assert_eq!((job.task, job.state), (None, JobState::Waiting));
        assert_eq!((job.reason.as_str(), job.script), ("Nodes required, down", "/a|b.sh".into()));
        assert_eq!(job_of_line(""), None);
        assert_eq!(job_of_line("17|3|RUNNING"), None);
    }
}
