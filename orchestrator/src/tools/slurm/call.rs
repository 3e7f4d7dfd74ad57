//! Calls of Slurm's commands.

use std::path::Path;
use std::process::{Command, Stdio};

/// One of Slurm's commands did not do its work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{command}: {message}")]
pub struct SlurmError {
    /// The command.
    pub command: String,
    /// What it said.
    pub message: String,
}

/// Gives Slurm a script; returns the number of the job.
///
/// # Errors
/// What `sbatch` says.
pub fn submit(script: &Path) -> Result<String, SlurmError> {
    let job = output_of(Command::new("sbatch").arg("--parsable").arg(script))?;
    // With a cluster's name behind it where there are several.
    Ok(job.trim().split(';').next().unwrap_or_default().to_string())
}

/// Output of one of Slurm's commands.
pub(super) fn output_of(command: &mut Command) -> Result<String, SlurmError> {
    let name = command.get_program().to_string_lossy().into_owned();
    let failed = |message: String| SlurmError { command: name.clone(), message };
    let output =
        command.stdin(Stdio::null()).output().map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(failed(format!("{}; {}", said.trim(), output.status)))
}
