//! A run that is given to Slurm: checked here as far as can be, then submitted as one job.

use super::check::show_plan;
use super::follow_job::{JobFollower, how_it_goes_on};
use super::interrupts::count_interrupts;
use crate::manifest::{ComponentSpec, Manifest};
use crate::outputs::{OutputError, RunFolder, SLURM};
use crate::program::cli::View;
use crate::program::slurm_args::SlurmArgs;
use crate::run::{Execution, RunError, prepare};
use crate::terminal::Terminal;
use crate::terminal::standard::answer_text;
use crate::tools::shell::shell_line;
use crate::tools::slurm::{JobSize, NotSubmitted, RunJob, RunScript};
use serde_json::{Value, json};
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicUsize;
use tremie_messages::Problem;

/// A run that shall be given to Slurm.
pub(super) struct SlurmOrder<'a> {
    pub manifest: &'a Manifest,
    /// Folder in which programs are looked for first.
    pub programs: &'a Path,
    pub execution: Execution,
    pub view: &'a View,
    pub at_slurm: &'a SlurmArgs,
}

impl SlurmOrder<'_> {
    /// Checks the run, submits it with its outputs in the folder that `claim` gives, and follows it; `words`
    /// are the command of the job, by the folder.
    pub(super) fn carry_out(
        self,
        terminal: &mut Terminal,
        claim: impl FnOnce() -> Result<RunFolder, OutputError>,
        words: impl FnOnce(&Path) -> Vec<OsString>,
    ) -> Result<ExitCode, RunError> {
        let interrupts = count_interrupts().map_err(RunError::Signals)?;
        self.check(terminal, &interrupts)?;
        let folder = claim()?;
        let out = folder.path().to_path_buf();
        let script = self.script(&out, words(&out));
        if let (Ok(script), true) = (&script, self.at_slurm.print) {
            answer_text(script.text(&out.join(SLURM)));
            return Ok(ExitCode::SUCCESS);
        }
        let written = script.and_then(|script| {
            not_at_slurm(&out)?;
            RunJob::write(&out, &script)
        });
        // The job claims it, and may do so before Slurm's answer is here. The script keeps others out.
        drop(folder);
        let submitted = written.and_then(|job| job.submit(&out));
        match submitted {
            Ok(job) => Ok(self.follow(job, &out, terminal, &interrupts)),
            Err(error) => {
                terminal.fail(&error.to_string());
                Ok(ExitCode::FAILURE)
            }
        }
    }

    /// All that can be found wrong before the run begins. Programs with a launcher are asked as one process
    /// each: the launcher of a cluster begins nothing outside a job.
    fn check(&self, terminal: &Terminal, interrupts: &AtomicUsize) -> Result<(), RunError> {
        if matches!(self.view, View::Web | View::Native) {
            let text = "a job has no display and no browser";
            let help = "write --view FILE.rrd, or --view none";
            return Err(RunError::Input(vec![Problem::new("--view", text).help(help)]));
        }
        let execution = Execution { unlaunched: true, ..self.execution.clone() };
        let prepared =
            prepare(self.manifest, self.programs, Path::new(""), &execution, interrupts)?;
        show_plan(self.manifest, &prepared, terminal);
        prepared.dismiss();
        Ok(())
    }

    /// The script of the job, with the `words` of its command.
    fn script(&self, out: &Path, words: Vec<OsString>) -> Result<RunScript, NotSubmitted> {
        let spec = &self.manifest.spec;
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let is_open =
            |component: &&ComponentSpec| component.threads.is_none() && component.role.has_steps();
        Ok(RunScript {
            name: format!("tremie-{name}"),
            size: JobSize::of(spec),
            options: self.at_slurm.slurm_option.clone(),
            line: shell_line(words)
                .map_err(|error| NotSubmitted::Io { path: "/proc/self/exe".into(), error })?,
            open: spec.components.iter().filter(is_open).map(|one| one.name.clone()).collect(),
        })
    }

    /// Tells of the job, and follows it if its user wants that.
    fn follow(
        &self,
        job: RunJob,
        out: &Path,
        terminal: &mut Terminal,
        interrupts: &AtomicUsize,
    ) -> ExitCode {
        let (number, path) = (job.name(), out.display());
        terminal.event(json!({"event": "job", "job": number, "script": job.script, "out": out}));
        terminal.say(&format!("Slurm has the run as job {number}; outputs in {path}"));
        if self.at_slurm.detach {
            terminal.end(&how_it_goes_on(&job, out), Value::Null);
            return ExitCode::SUCCESS;
        }
        JobFollower::new(job, out, terminal, interrupts, false).follow()
    }
}

/// Two jobs of one folder would get into each other's way.
fn not_at_slurm(out: &Path) -> Result<(), NotSubmitted> {
    let Some(mut job) = RunJob::of(out) else { return Ok(()) };
    match job.in_queue()? {
        Some(_) => Err(NotSubmitted::There(how_it_goes_on(&job, out))),
        None => Ok(()),
    }
}
