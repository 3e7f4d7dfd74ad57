//! Commands to a run in progress.

use super::WRONG_INPUT;
use crate::outputs::SUMMARY;
use crate::program::steer_args::SteerCommand;
use crate::steering::{
    Answer, LivingRun, NotReached, RunState, RunStatus, SteeringCommand, find, living,
};
use crate::terminal::standard::{answer, complain};
use crate::terminal::{Style, Terminal};
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Interval of the looks at a run that is attached to.
const LOOK: Duration = Duration::from_millis(200);
/// Time for which a run that no longer answers is looked for: one that takes a change starts again.
const RETURN: Duration = Duration::from_secs(3);

/// Carries out a command to a run in progress.
pub fn steer(command: SteerCommand) -> ExitCode {
    let (run, command) = match command {
        SteerCommand::Ps { json } => return list(json),
        SteerCommand::Attach(choice) => return attach(choice.run.as_deref()),
        SteerCommand::Pause(choice) => (choice.run, SteeringCommand::Pause {}),
        SteerCommand::Step { windows, run } => (run.run, SteeringCommand::Step { windows }),
        SteerCommand::Continue(choice) => (choice.run, SteeringCommand::Continue {}),
        SteerCommand::Set { changes, run } => (run, SteeringCommand::Set { changes }),
        SteerCommand::Checkpoint(choice) => (choice.run, SteeringCommand::Checkpoint {}),
        SteerCommand::Stop(choice) => (choice.run, SteeringCommand::Stop {}),
    };
    let run = match find(run.as_deref()) {
        Ok(run) => run,
        Err(error) => return not_reached(&error),
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

fn not_reached(error: &NotReached) -> ExitCode {
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

/// `tremie attach`: shows the progress of a run until it ends.
fn attach(run: Option<&str>) -> ExitCode {
    let mut terminal = Terminal::new(Style::Person);
    let (mut run, mut status) =
        match find(run).and_then(|run| run.status().map(|status| (run, status))) {
            Ok(found) => found,
            Err(error) => return not_reached(&error),
        };
    let out = status.out.clone();
    terminal.say(&format!("run {}, outputs in {}", status.run, out.display()));
    let mut shown = RunState::Running;
    loop {
        if status.state != shown {
            shown = status.state;
            let window = status.progress.window;
            terminal.say(&format!("{} at window {window}", shown.name()));
        }
        if terminal.wants_progress() {
            terminal.progress(&status.progress);
        }
        std::thread::sleep(LOOK);
        status = match run.status() {
            Ok(status) => status,
            Err(_) => match await_return(&out, None) {
                Some((again, status)) => {
                    run = again;
                    terminal.say(&format!("goes on as run {}", status.run));
                    status
                }
                None => break,
            },
        };
    }
    let (text, code) = end_of(&out);
    terminal.end(&text, Value::Null);
    code
}

/// The run, another than `before`, that writes into `out` again; `None` if there is none for a while.
fn await_return(out: &Path, before: Option<&LivingRun>) -> Option<(LivingRun, RunStatus)> {
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
