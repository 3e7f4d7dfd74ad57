//! The job of a run: how it is submitted, and found again from any terminal.

use super::call::{SlurmError, submit};
use super::job_end::{JobEnd, last_words};
use super::queue::{QueuedJob, queued};
use super::run_script::RunScript;
use crate::outputs::{SLURM, SUMMARY};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tremie_state::write_whole;

/// File that names the job, in the run's folder of what belongs to Slurm.
const RECORD: &str = "job.json";

/// Why a run is not at Slurm.
#[derive(Debug, thiserror::Error)]
pub enum NotSubmitted {
    /// It has not taken the script.
    #[error(
        "{0}\n--slurm needs the commands of a Slurm cluster, and a folder that all nodes share; --print shows the script"
    )]
    Slurm(#[from] SlurmError),
    /// It has the run already.
    #[error("{0}")]
    There(String),
    /// The script, or the record of the job, cannot be written.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        error: io::Error,
    },
}

impl NotSubmitted {
    fn io(path: &Path) -> impl Fn(io::Error) -> Self + '_ {
        |error| Self::Io { path: path.to_path_buf(), error }
    }
}

/// A run that was given to Slurm.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunJob {
    /// Its script, by which it is known at Slurm.
    pub script: PathBuf,
    /// Number of the job; `None` where the submission was broken off before Slurm told it.
    pub job: Option<String>,
    /// Number of the run whose end stands in the folder from before.
    before: Option<String>,
}

impl RunJob {
    /// Writes the script of a run with outputs in `out`, an absolute path, and a record of the job to come: from
    /// before Slurm gets it on, the script tells the job in the queue.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn write(out: &Path, script: &RunScript) -> Result<Self, NotSubmitted> {
        let folder = out.join(SLURM);
        std::fs::create_dir_all(&folder).map_err(NotSubmitted::io(&folder))?;
        let number = (1..).find(|k| !folder.join(format!("{k}.sh")).exists()).unwrap_or(1);
        let path = folder.join(format!("{number}.sh"));
        std::fs::write(&path, script.text(&folder)).map_err(NotSubmitted::io(&path))?;
        let before = summary_in(out).and_then(|summary| number_of(&summary));
        let job = Self { script: path, job: None, before };
        job.note(&folder)?;
        Ok(job)
    }

    /// Gives Slurm the script, of outputs in `out`.
    ///
    /// # Errors
    /// If Slurm refuses: what was written is gone then, and the folder, if it holds nothing else.
    pub fn submit(mut self, out: &Path) -> Result<Self, NotSubmitted> {
        let folder = out.join(SLURM);
        let submitted = submit(&self.script).map_err(NotSubmitted::from);
        if submitted.is_err() {
            let _ = std::fs::remove_file(&self.script);
            let _ = std::fs::remove_file(folder.join(RECORD));
            let _ = std::fs::remove_dir(&folder).and_then(|()| std::fs::remove_dir(out));
        }
        self.job = Some(submitted?);
        self.note(&folder)?;
        Ok(self)
    }

    fn note(&self, folder: &Path) -> Result<(), NotSubmitted> {
        let path = folder.join(RECORD);
        let text = serde_json::to_vec_pretty(self).unwrap_or_default();
        write_whole(&path, |file| file.write_all(&text)).map_err(NotSubmitted::io(&path))
    }

    /// The job that was submitted last for the run of the folder `out`.
    pub fn of(out: &Path) -> Option<Self> {
        let text = std::fs::read(out.join(SLURM).join(RECORD)).ok()?;
        serde_json::from_slice(&text).ok()
    }

    /// The same, seen from outside the job: in it, a run that is not found is not there.
    pub fn from_outside(out: &Path) -> Option<Self> {
        let own = std::env::var("SLURM_JOB_ID").ok();
        Self::of(out).filter(|job| own.is_none() || job.job != own)
    }

    /// The job in Slurm's queue; `None` once it has ended.
    ///
    /// # Errors
    /// What `squeue` says.
    pub fn in_queue(&mut self) -> Result<Option<QueuedJob>, SlurmError> {
        let found = queued()?.into_iter().find(|queued| match &self.job {
            Some(job) => queued.job == *job,
            None => queued.script == self.script,
        });
        self.job = self.job.take().or_else(|| found.as_ref().map(|found| found.job.clone()));
        Ok(found)
    }

    /// Number of the job, for the user.
    pub fn name(&self) -> &str {
        self.job.as_deref().unwrap_or("of unknown number")
    }

    /// The summary of the run in the folder `out`, if this job made it.
    pub fn summary(&self, out: &Path) -> Option<Value> {
        summary_in(out).filter(|summary| number_of(summary) != self.before)
    }

    /// What Slurm says of the job once it has ended.
    pub fn end(&self) -> JobEnd {
        JobEnd::asked(self.name().into())
    }

    /// The last lines that it wrote.
    pub fn last_words(&self) -> Vec<String> {
        let file = format!("{}.txt", self.name());
        last_words(&self.script.with_file_name(file))
    }
}

fn summary_in(out: &Path) -> Option<Value> {
    let text = std::fs::read_to_string(out.join(SUMMARY)).ok()?;
    serde_json::from_str(&text).ok()
}

/// Number of the run that a summary is of.
fn number_of(summary: &Value) -> Option<String> {
    summary["run"].as_str().map(String::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_is_found_by_its_record_and_knows_its_own_end() {
        let home = tempfile::tempdir().unwrap();
        let (out, folder) = (home.path(), home.path().join(SLURM));
        assert_eq!(RunJob::of(out), None);
        std::fs::create_dir(&folder).unwrap();
        let before = Some("a".to_string());
        let job = RunJob { script: folder.join("1.sh"), job: Some("17".into()), before };
        job.note(&folder).unwrap();
        assert_eq!(RunJob::of(out).as_ref(), Some(&job));
        std::fs::write(out.join(SUMMARY), r#"{"run": "a"}"#).unwrap();
        assert_eq!(job.summary(out), None, "the end of a job before");
        std::fs::write(out.join(SUMMARY), r#"{"run": "b"}"#).unwrap();
        assert!(job.summary(out).is_some());
        std::fs::write(folder.join("17.txt"), "one\ntwo\n").unwrap();
        assert_eq!(job.last_words(), ["one", "two"]);
    }
}
