//! Commands of the program.
//!
//! Standard output has the answer of a command: the plan and the verdicts of `check`, lists,
//! schemas, paths of written files; with `--json` everything. Standard error has errors, and the
//! messages of `run` and `view` about their work.
//!
//! Exit codes: 0 success; 1 a run failed, a check did not hold, or bits differ; 2 the input is wrong; 130 the
//! user ended a run; 141 the reader of the answer stopped reading, as `head` does. A command that
//! could not write its answer never ends with 0.

mod at_slurm;
mod attach;
mod bench;
mod carry_out;
mod check;
mod diff;
mod follow_job;
mod interrupts;
mod new_scene;
mod packages;
mod replay;
mod report;
mod resume;
mod run;
mod signals;
mod simple;
mod steer;
mod study;
mod validate;
mod view;

pub use bench::bench;
pub use check::check;
pub use diff::diff;
pub use new_scene::new_scene;
pub use packages::{of_package, reader};
pub use replay::replay;
pub use report::report;
pub use resume::resume;
pub use run::run;
pub use signals::signals;
pub use simple::{clean, component, components, conform, explain, schema};
pub use steer::steer;
pub use study::study;
pub use validate::validate;
pub use view::view;

use crate::manifest::{Manifest, ManifestErrors};
use crate::run::RunError;
use crate::terminal::Terminal;
use crate::terminal::standard::{answer_text, complain_text};
use serde_json::Value;
use std::io::IsTerminal;
use std::process::ExitCode;

/// The input is wrong.
const WRONG_INPUT: u8 = 2;
/// The user asked for the end.
const INTERRUPTED: u8 = 130;

/// Answers `--help` and `--version`, or reports an error of the command line.
pub fn usage(word: &clap::Error) -> ExitCode {
    let text = word.render();
    let coloured = |is_terminal: bool| is_terminal && std::env::var_os("NO_COLOR").is_none();
    if word.use_stderr() {
        let is_terminal = std::io::stderr().is_terminal();
        complain_text(if coloured(is_terminal) {
            text.ansi().to_string()
        } else {
            text.to_string()
        });
        return ExitCode::from(WRONG_INPUT);
    }
    let is_terminal = std::io::stdout().is_terminal();
    answer_text(if coloured(is_terminal) { text.ansi().to_string() } else { text.to_string() });
    ExitCode::SUCCESS
}

/// Reports the errors in a manifest's text.
fn refuse_text(errors: &ManifestErrors, json: bool, terminal: &Terminal) -> ExitCode {
    if json {
        answer_text(errors.json_lines());
    } else {
        complain_text(errors.render(terminal.colour()));
    }
    ExitCode::from(WRONG_INPUT)
}

/// Reports the error that kept a run or a check from beginning.
fn refuse(error: &RunError, manifest: &Manifest, json: bool, terminal: &mut Terminal) -> ExitCode {
    match error {
        RunError::Input(problems) => {
            if json {
                answer_text(manifest.source.json_lines(problems));
            } else {
                complain_text(manifest.source.render(problems, terminal.colour()));
            }
            ExitCode::from(WRONG_INPUT)
        }
        RunError::Interrupted => {
            terminal.end(&error.to_string(), Value::Null);
            ExitCode::from(INTERRUPTED)
        }
        other => {
            terminal.fail(&other.to_string());
            ExitCode::FAILURE
        }
    }
}
