//! `tremie conform PROGRAM`: what any component must do before a user trusts it, seen from outside.

mod checks;
mod subject;

use crate::cli::ConformArgs;
use std::process::ExitCode;
use subject::Subject;

/// Tries the program and prints a line for each check.
///
/// Exit code 0 if all hold, 1 if one does not, 2 if the program cannot be tried.
pub fn conform(arguments: &ConformArgs) -> ExitCode {
    let subject = match Subject::find(arguments) {
        Ok(subject) => subject,
        Err(text) => {
            eprintln!("error: {text}");
            return ExitCode::from(2);
        }
    };
    println!("{} as {}", arguments.program, subject.role);
    let mut failed = 0;
    for check in checks::ALL {
        match (check.holds)(&subject) {
            Ok(()) => println!("  ok      {}", check.name),
            Err(why) => {
                failed += 1;
                println!("  FAILED  {}\n          {why}", check.name);
            }
        }
    }
    let total = checks::ALL.len();
    if failed == 0 {
        println!("conforms: {total} checks hold");
        ExitCode::SUCCESS
    } else {
        println!("does not conform: {failed} of {total} checks fail");
        ExitCode::FAILURE
    }
}
