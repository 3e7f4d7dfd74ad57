//! Commands to a run in progress.

use super::WRONG_INPUT;
use super::attach::{attach, await_return};
use crate::program::steer_args::SteerCommand;
use crate::steering::{
    Answer, LivingRun, NotReached, RunState, RunStatus, SteeringCommand, find, living,
};
use crate::terminal::standard::{answer, complain};
use crate::tools::slurm::{JobState, RunJob, step_of};
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;

/// Carries out a command to a run in progress.
pub fn steer(command: SteerCommand) -> ExitCode {
    let (run, command) = match command {
        SteerCommand::Ps { json } => return list(json),
        SteerCommand::Attach(arguments) => return attach(&arguments),
        SteerCommand::Pause(choice) => (choice.run, SteeringCommand::Pause {}),
        SteerCommand::Step { windows, run } => (run.run, SteeringCommand::Step { windows }),
        SteerCommand::Continue(choice) => (choice.run, SteeringCommand::Continue {}),
        SteerCommand::Set { changes, run } => (run, SteeringCommand::Set { changes }),
        SteerCommand::Checkpoint(choice) => (choice.run, SteeringCommand::Checkpoint {}),
        SteerCommand::Stop(choice) => (choice.run, SteeringCommand::Stop {}),
    };
    let word = run.as_deref();
    let run = match find(word) {
        Ok(run) => run,
        Err(error) => {
            let code = word.and_then(|out| ask_in_job(Path::new(out), &command));
            return code.unwrap_or_else(|| not_reached(&error));
        }
    };
    match run.ask(&command, None) {
        Ok(Answer::Done { text, .. }) => {
            if let (SteeringCommand::Set { .. }, Some(out)) = (&command, run.out()) {
                // The next command finds the run again.
                await_return(&out, Some(&run));
            }
            answer(text);
            ExitCode::SUCCESS
        }
        Ok(Answer::Refused { why }) => {
            complain(format_args!("error: {why}"));
            ExitCode::FAILURE
        }
        Ok(Answer::Status(status)) => {
            answer(line(&status));
            ExitCode::SUCCESS
        }
        Err(error) => not_reached(&error),
    }
}

/// Gives a command to a run at Slurm, by a step of its job on the machine where it is; `None` where no job in
/// Slurm's queue has the outputs `out`.
fn ask_in_job(out: &Path, command: &SteeringCommand) -> Option<ExitCode> {
    let out = std::path::absolute(out).ok()?;
    let mut job = RunJob::from_outside(&out)?;
    let queued = job.in_queue().ok()??;
    if queued.state == JobState::Waiting {
        let number = job.name();
        complain(format_args!(
            "error: job {number} waits in Slurm's queue, and its run takes no commands yet; `scancel {number}` takes it out"
        ));
        return Some(ExitCode::FAILURE);
    }
    let step = step_of(job.name(), command.words(&out)).and_then(|mut step| step.status());
    Some(match step {
        Ok(status) => {
            let code = status.code().and_then(|code| u8::try_from(code).ok());
            code.map_or(ExitCode::FAILURE, ExitCode::from)
        }
        Err(error) => {
            complain(format_args!("error: srun: {error}"));
            ExitCode::FAILURE
        }
    })
}

pub(super) fn not_reached(error: &NotReached) -> ExitCode {
    complain(format_args!("error: {error}"));
    let is_input = matches!(error, NotReached::Several | NotReached::Unknown(_));
    if is_input { ExitCode::from(WRONG_INPUT) } else { ExitCode::FAILURE }
}

/// `tremie ps`.
fn list(json: bool) -> ExitCode {
    let runs = match living() {
        Ok(runs) => runs,
        Err(error) => return not_reached(&error),
    };
    if runs.is_empty() && !json {
        answer("no run of yours is in progress");
    }
    for run in &runs {
        let status = run.status();
        match (&status, json) {
            (Ok(status), true) => {
                answer(serde_json::to_value(status).unwrap_or(Value::Null));
            }
            (Ok(status), false) => answer(line(status)),
            // Its components get ready, or it is at its end.
            (Err(_), _) => answer(starting(run, json)),
        }
    }
    ExitCode::SUCCESS
}

/// What is known of a run that does not answer yet.
fn starting(run: &LivingRun, json: bool) -> String {
    let (number, name, out) =
        (run.number(), RunState::Starting.name(), run.out().unwrap_or_default());
    match json {
        true => json!({"run": number, "state": name, "out": out}).to_string(),
        false => format!("{number}  {name:8}  {}", out.display()),
    }
}

/// A line about a run.
fn line(status: &RunStatus) -> String {
    let RunStatus { run, state, out, progress, checkpoint, .. } = status;
    let percent = 100 * progress.window / progress.windows.max(1);
    let kept = checkpoint.map_or(String::new(), |window| format!(", checkpoint of {window}"));
    format!(
        "{run}  {:8}  {percent:3} %  window {} of {}, {:.6} s, {:.1} windows/s{kept}  {}",
        state.name(),
        progress.window,
        progress.windows,
        progress.time,
        progress.rate,
        out.display()
    )
}
