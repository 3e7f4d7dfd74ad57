//! `tremie replay OUT --only COMPONENT`: one component against the recorded messages of the others.

use super::interrupts::count_interrupts;
use super::{INTERRUPTED, WRONG_INPUT, refuse, refuse_text};
use crate::outputs::Ending;
use crate::program::cli::ReplayArgs;
use crate::terminal::{Style, Terminal};
use crate::tools::replay::{ReplayError, ReplayOrder, Replayed, replay as carry_out};
use serde_json::json;
use std::process::ExitCode;

/// `tremie replay`: success if the component sent the recorded bits.
pub fn replay(arguments: &ReplayArgs) -> ExitCode {
    let mut terminal = Terminal::new(Style::asked(arguments.quiet, arguments.json));
    let interrupts = match count_interrupts() {
        Ok(interrupts) => interrupts,
        Err(error) => {
            terminal.fail(&format!("cannot watch for Ctrl-C: {error}"));
            return ExitCode::FAILURE;
        }
    };
    let order = ReplayOrder {
        run: &arguments.run,
        component: &arguments.only,
        at: arguments.at,
        sets: &arguments.set,
        programs: arguments.programs.as_deref(),
        out: arguments.out.as_deref(),
        in_process: arguments.in_process,
    };
    match carry_out(&order, &mut terminal, &interrupts) {
        Ok(replayed) => tell(&replayed, &arguments.only, &mut terminal),
        Err(ReplayError::Manifest(errors)) => refuse_text(&errors, arguments.json, &terminal),
        Err(ReplayError::Run(error, manifest)) => {
            refuse(&error, &manifest, arguments.json, &mut terminal)
        }
        Err(error) => {
            terminal.fail(&error.to_string());
            WRONG_INPUT.into()
        }
    }
}

fn tell(replayed: &Replayed, component: &str, terminal: &mut Terminal) -> ExitCode {
    let Replayed { from, last, windows, ending } = replayed;
    let (text, code) = match (replayed.difference(), ending) {
        (Some(fault), _) => (format!("other bits than recorded: {}", fault.message), 1),
        (None, Ending::Failed { fault, .. }) => (format!("the replay failed: {fault}"), 1),
        (None, Ending::Interrupted) => {
            (format!("interrupted at window {windows}: the recorded bits up to there"), INTERRUPTED)
        }
        _ => (format!("the recorded bits: {component}, windows {} to {last}", from + 1), 0),
    };
    let summary = json!({
        "component": component,
        "same": replayed.is_same(),
        "from": from,
        "windows": windows,
        "recorded": last,
        "difference": replayed.difference(),
    });
    terminal.end(&text, summary);
    code.into()
}
