//! The user's end of steering: runs in progress, and how to reach them.

use super::{Answer, OUTPUTS, RunStatus, SOCKET, SteeringCommand};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::ffi::OsStringExt;
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Longest wait for the status of a run.
const STATUS_WITHIN: Duration = Duration::from_secs(2);

/// A run in progress.
#[derive(Clone, Debug)]
pub struct LivingRun {
    /// Its number.
    pub run: u64,
    folder: PathBuf,
}

/// Why a run was not reached.
#[derive(Debug, thiserror::Error)]
pub enum NotReached {
    /// There is none.
    #[error("no run of yours is in progress")]
    None,
    /// There are several, and none was named.
    #[error(
        "several runs are in progress: name one by its number or the folder of its outputs; `tremie ps` lists them"
    )]
    Several,
    /// There is none of that name.
    #[error(
        "no run in progress has the number or the outputs \"{0}\"; `tremie ps` lists those that are"
    )]
    Unknown(String),
    /// It is there, and does not answer.
    #[error("run {run:016x} does not answer: {why}")]
    Silent {
        /// Its number.
        run: u64,
        /// What happened.
        why: String,
    },
    /// The folder of all runs cannot be read.
    #[error("cannot look for runs: {0}")]
    Folder(io::Error),
}

/// All runs of this user that are in progress.
///
/// # Errors
/// [`NotReached::Folder`].
pub fn living() -> Result<Vec<LivingRun>, NotReached> {
    let runs = tremie_channels::sweep::living_runs().map_err(NotReached::Folder)?;
    Ok(runs.into_iter().map(|(run, folder)| LivingRun { run, folder }).collect())
}

/// The run that `word` names: the begin of its number, or the folder of its outputs; without a word, the
/// only one.
///
/// # Errors
/// Any of [`NotReached`].
pub fn find(word: Option<&str>) -> Result<LivingRun, NotReached> {
    let mut runs = living()?;
    let Some(word) = word else {
        let last = runs.pop().ok_or(NotReached::None)?;
        return if runs.is_empty() { Ok(last) } else { Err(NotReached::Several) };
    };
    let is_it = |run: &&LivingRun| run.out().is_some_and(|out| is_same(&out, Path::new(word)));
    if let Some(found) = runs.iter().find(is_it) {
        return Ok(found.clone());
    }
    let numbered = |run: &&LivingRun| !word.is_empty() && run.number().starts_with(word);
    let mut found = runs.iter().filter(numbered);
    match (found.next(), found.next()) {
        (Some(run), None) => Ok(run.clone()),
        (Some(_), Some(_)) => Err(NotReached::Several),
        (None, _) => Err(NotReached::Unknown(word.into())),
    }
}

/// True if two paths lead to one folder.
fn is_same(one: &Path, other: &Path) -> bool {
    matches!((one.canonicalize(), other.canonicalize()), (Ok(one), Ok(other)) if one == other)
}

impl LivingRun {
    /// Its number, in hexadecimal.
    pub fn number(&self) -> String {
        format!("{:016x}", self.run)
    }

    /// Folder of its outputs, an absolute path; `None` in the moment before it says so.
    pub fn out(&self) -> Option<PathBuf> {
        let path = std::fs::read(self.folder.join(OUTPUTS)).ok()?;
        Some(OsString::from_vec(path).into())
    }

    /// How far it is.
    ///
    /// # Errors
    /// [`NotReached::Silent`].
    pub fn status(&self) -> Result<RunStatus, NotReached> {
        match self.ask(&SteeringCommand::Status {}, Some(STATUS_WITHIN))? {
            Answer::Status(status) => Ok(*status),
            other => Err(self.silent(format!("it said {other:?}"))),
        }
    }

    /// Gives the run a command, and waits for its answer, `within` some time or without end.
    ///
    /// # Errors
    /// [`NotReached::Silent`].
    pub fn ask(
        &self,
        command: &SteeringCommand,
        within: Option<Duration>,
    ) -> Result<Answer, NotReached> {
        let answer = self.exchange(command, within).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::ConnectionRefused => {
                self.silent("its components are not ready yet, or it is at its end".into())
            }
            io::ErrorKind::WouldBlock => self.silent("nothing came in time".into()),
            _ => self.silent(error.to_string()),
        })?;
        serde_json::from_str(&answer).map_err(|error| self.silent(error.to_string()))
    }

    fn exchange(&self, command: &SteeringCommand, within: Option<Duration>) -> io::Result<String> {
        let mut stream = UnixStream::connect(self.folder.join(SOCKET))?;
        stream.set_read_timeout(within)?;
        let mut line = serde_json::to_vec(command)?;
        line.push(b'\n');
        stream.write_all(&line)?;
        let mut answer = String::new();
        match BufReader::new(stream).read_line(&mut answer)? {
            0 => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the run has ended")),
            _ => Ok(answer),
        }
    }

    fn silent(&self, why: String) -> NotReached {
        NotReached::Silent { run: self.run, why }
    }
}
