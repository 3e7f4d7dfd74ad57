//! Steps in the job of a run: this program once more, on the machine where the run is.
//!
//! A run is steered over a socket on its own machine, and only its user can reach it. A step of its job is on
//! that machine, and of that user.

use crate::run::launch::{Signal, end_with_us, own_words};
use crate::steering::RunStatus;
use rustix::process::{Pid, kill_process};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Longest time that a step may take to end.
const GRACE: Duration = Duration::from_secs(5);

/// The command that runs this program with `arguments` beside the run of a job, on its first node.
///
/// # Errors
/// If the system does not tell where this program lies.
pub fn step_of(job: &str, arguments: impl IntoIterator<Item = OsString>) -> io::Result<Command> {
    let mut command = Command::new("srun");
    command.arg(format!("--jobid={job}"));
    // `--overlap`: the run has all cores of the job.
    command.args(["--overlap", "--nodes=1", "--ntasks=1", "--relative=0", "--quiet"]);
    command.args(own_words()?).args(arguments).stdin(Stdio::null());
    Ok(command)
}

/// What a run on another machine says of itself, as a step of its job passes it on.
pub struct StepStatuses {
    step: Child,
    statuses: Receiver<RunStatus>,
}

impl StepStatuses {
    /// Starts the step, of which the command is `attach --json`.
    ///
    /// # Errors
    /// If it cannot be started.
    pub fn start(mut command: Command) -> io::Result<Self> {
        // Ctrl-C in a terminal goes to this program alone, which ends the step.
        command.stdout(Stdio::piped()).stderr(Stdio::null()).process_group(0);
        let mut step = end_with_us(&mut command, Signal::TERM).spawn()?;
        let (sender, statuses) = channel();
        let output = step.stdout.take();
        let read = move || {
            let lines = output.into_iter().flat_map(|output| BufReader::new(output).lines());
            let of_line = |line: String| serde_json::from_str(&line).ok();
            let statuses = lines.map_while(Result::ok).filter_map(of_line);
            for status in statuses {
                if sender.send(status).is_err() {
                    return;
                }
            }
        };
        std::thread::Builder::new().spawn(read)?;
        Ok(Self { step, statuses })
    }

    /// The newest status, once one has come.
    ///
    /// # Errors
    /// If none has come in time, or none will: the run has ended, or is not reached.
    pub fn newest(&self, within: Duration) -> Result<RunStatus, RecvTimeoutError> {
        let status = self.statuses.recv_timeout(within)?;
        Ok(self.statuses.try_iter().last().unwrap_or(status))
    }
}

impl Drop for StepStatuses {
    fn drop(&mut self) {
        if let Ok(None) = self.step.try_wait()
            && let Some(id) = i32::try_from(self.step.id()).ok().and_then(Pid::from_raw)
        {
            // Slurm's program passes it on to the step.
            let _ = kill_process(id, Signal::TERM);
        }
        let begin = Instant::now();
        while let Ok(None) = self.step.try_wait() {
            if begin.elapsed() > GRACE {
                let _ = self.step.kill();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
