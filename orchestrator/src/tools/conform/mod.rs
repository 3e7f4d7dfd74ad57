//! `tremie conform PROGRAM`: checks of a component's contract, seen from outside.

mod checks;
mod subject;

use crate::terminal::standard::{answer, complain, is_lost};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use subject::Subject;

/// Arguments of `tremie conform`.
#[derive(Debug, Args)]
pub struct ConformArgs {
    /// Program, or the name of a built-in component
    pub program: String,
    /// Manifest whose scene and settings the program is tried with [default: a small scene]
    #[arg(long)]
    pub manifest: Option<PathBuf>,
    /// Role that it shall take: fluid or grains
    #[arg(long, value_name = "ROLE")]
    pub role: Option<String>,
}

/// Tries the program and prints a line for each check.
///
/// Exit code 0 if all hold, 1 if one does not, 2 if the program cannot be tried.
pub fn conform(arguments: &ConformArgs) -> ExitCode {
    let subject = match Subject::find(arguments) {
        Ok(subject) => subject,
        Err(text) => {
            complain(format_args!("error: {text}"));
            return ExitCode::from(2);
        }
    };
    answer(format_args!("{} as {}", arguments.program, subject.role));
    let mut failed = 0;
    for check in checks::ALL {
        if is_lost() {
            // No reader is left: `main` chooses the exit code.
            return ExitCode::SUCCESS;
        }
        match (check.holds)(&subject) {
            Ok(()) => answer(format_args!("  ok      {}", check.name)),
            Err(why) => {
                failed += 1;
                answer(format_args!("  FAILED  {}\n          {why}", check.name));
            }
        }
    }
    let total = checks::ALL.len();
    if failed == 0 {
        answer(format_args!("conforms: {total} checks hold"));
        ExitCode::SUCCESS
    } else {
        answer(format_args!("does not conform: {failed} of {total} checks fail"));
        ExitCode::FAILURE
    }
}
