//! `tremie attach`: a run in progress, live, wherever it is.

use super::follow_job::JobFollower;
use super::steer::not_reached;
use crate::outputs::SUMMARY;
use crate::program::steer_args::AttachArgs;
use crate::steering::{LivingRun, RunState, RunStatus, find, living};
use crate::terminal::standard::{answer, is_lost};
use crate::terminal::{Style, Terminal};
use crate::tools::slurm::RunJob;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicUsize;
use std::time::{Duration, Instant};

/// Interval of the looks at a run that is attached to.
const LOOK: Duration = Duration::from_millis(200);
/// The same for a program that reads them.
const LOOK_OF_PROGRAM: Duration = Duration::from_secs(1);
/// Time for which a run that no longer answers is looked for: one that takes a change starts again.
const RETURN: Duration = Duration::from_secs(3);

/// Shows the progress of a run until it ends.
pub(super) fn attach(arguments: &AttachArgs) -> ExitCode {
    let style = if arguments.json { Style::Silent } else { Style::Person };
    let mut terminal = Terminal::new(style);
    let word = arguments.choice.run.as_deref();
    let found = find(word).and_then(|run| run.status().map(|status| (run, status)));
    let (run, status) = match found {
        Ok(found) => found,
        Err(error) => {
            let out = word.map(Path::new).and_then(|out| std::path::absolute(out).ok());
            let job = out.as_deref().and_then(RunJob::from_outside).zip(out.as_deref());
            let Some((job, out)) = job else { return not_reached(&error) };
            // Ctrl-C ends this command at once: nothing is to be told.
            let never = AtomicUsize::new(0);
            return JobFollower::new(job, out, &mut terminal, &never, arguments.json).follow();
        }
    };
    let out = status.out.clone();
    let mut looks = LocalLooks::new(run, &out);
    show(status, || looks.next(), &mut terminal, arguments.json);
    let (text, code) = end_of(&out);
    terminal.end(&text, Value::Null);
    code
}

/// Shows what a run says of itself, until `next` gives nothing any more.
pub(super) fn show(
    mut status: RunStatus,
    mut next: impl FnMut() -> Option<RunStatus>,
    terminal: &mut Terminal,
    for_program: bool,
) {
    terminal.say(&format!("run {}, outputs in {}", status.run, status.out.display()));
    let mut shown = RunState::Running;
    let mut run = status.run.clone();
    let mut told: Option<Instant> = None;
    loop {
        if status.run != run {
            run = status.run.clone();
            terminal.say(&format!("goes on as run {run}"));
        }
        if status.state != shown {
            shown = status.state;
            terminal.say(&format!("{} at window {}", shown.name(), status.progress.window));
        }
        if terminal.wants_progress() {
            terminal.progress(&status.progress);
        }
        if for_program && told.is_none_or(|told| told.elapsed() >= LOOK_OF_PROGRAM) {
            told = Some(Instant::now());
            answer(serde_json::to_value(&status).unwrap_or(Value::Null));
        }
        match next() {
            Some(next) if !is_lost() => status = next,
            _ => return,
        }
    }
}

/// Looks at a run on this machine, which may start again with a change.
pub(super) struct LocalLooks {
    run: LivingRun,
    /// Folder of its outputs, an absolute path, by which it is found again.
    out: PathBuf,
}

impl LocalLooks {
    pub(super) fn new(run: LivingRun, out: &Path) -> Self {
        Self { run, out: out.into() }
    }

    /// What the run says next; `None` once it has ended.
    pub(super) fn next(&mut self) -> Option<RunStatus> {
        std::thread::sleep(LOOK);
        if let Ok(status) = self.run.status() {
            return Some(status);
        }
        let (again, status) = await_return(&self.out, None)?;
        self.run = again;
        Some(status)
    }
}

/// The run, another than `before`, that writes into `out` again; `None` if there is none for a while.
pub(super) fn await_return(
    out: &Path,
    before: Option<&LivingRun>,
) -> Option<(LivingRun, RunStatus)> {
    let mut seen = Instant::now();
    while seen.elapsed() < RETURN {
        let is_it = |run: &LivingRun| run.out().as_deref() == Some(out);
        for run in living().ok()?.into_iter().filter(is_it) {
            let is_new = before.is_none_or(|before| before.run != run.run);
            match run.status() {
                Ok(status) if is_new => return Some((run, status)),
                // It is ending, or starting.
                _ => seen = Instant::now(),
            }
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    None
}

/// What became of a run that has ended.
fn end_of(out: &Path) -> (String, ExitCode) {
    let summary = std::fs::read_to_string(out.join(SUMMARY)).ok();
    let summary: Option<Value> = summary.and_then(|text| serde_json::from_str(&text).ok());
    let Some(summary) = summary else {
        let out = out.display();
        let text =
            format!("the run is gone without an end; `tremie resume {out}` may go on with it");
        return (text, ExitCode::FAILURE);
    };
    let status = summary["status"].as_str().unwrap_or("ended");
    let text = format!("{status}: {} windows; outputs in {}", summary["windows"], out.display());
    (text, ExitCode::from(u8::from(status == "failed")))
}
