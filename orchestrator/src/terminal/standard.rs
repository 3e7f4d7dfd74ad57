//! Standard output and standard error, for the whole program.
//!
//! Whoever reads may stop reading, and a file that standard output goes to may lie on a full disk. `println!` panics
//! then, and what ignores the error ends with code 0 although nothing was written. So all that the program prints goes
//! through here (a lint sees to it): [`answer`] and [`answer_text`] keep the first failure, and the program's `main`
//! ends with [`ending`]: quietly and with [`READER_GONE`] where the reader has gone, else with the system's words and
//! code 1.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

/// Exit code of a program whose reader has gone: what a shell shows for one that SIGPIPE ended.
pub const READER_GONE: u8 = 141;

/// Why standard output took no more.
static LOST: OnceLock<io::Error> = OnceLock::new();

/// Writes a line of what a command was asked for to standard output.
pub fn answer(line: impl Display) {
    answer_text(format_args!("{line}\n"));
}

/// Writes text of what a command was asked for to standard output.
pub fn answer_text(text: impl Display) {
    if is_lost() {
        return;
    }
    let mut output = io::stdout().lock();
    if let Err(error) = output.write_fmt(format_args!("{text}")).and_then(|()| output.flush()) {
        let _ = LOST.set(error);
    }
}

/// Whether standard output takes no more: a command that works only for its answer may stop.
pub fn is_lost() -> bool {
    LOST.get().is_some()
}

/// Writes a line to standard error. Where that fails nobody is left to be told.
pub fn complain(line: impl Display) {
    complain_text(format_args!("{line}\n"));
}

/// Writes text to standard error.
pub fn complain_text(text: impl Display) {
    // In one piece: lines of other processes on the same terminal do not get between.
    let _ = io::stderr().write_all(text.to_string().as_bytes());
}

/// The exit code of a command that would end with `code`, had standard output taken all of its answer.
pub fn ending(code: ExitCode) -> ExitCode {
    if let Err(error) = io::stdout().flush() {
        let _ = LOST.set(error);
    }
    match LOST.get() {
        None => code,
        Some(error) => {
            let is_gone = error.kind() == ErrorKind::BrokenPipe;
            if !is_gone {
                complain(format_args!("error: cannot write to standard output: {error}"));
            }
            // What failed by itself keeps its code.
            match (code == ExitCode::SUCCESS, is_gone) {
                (true, true) => READER_GONE.into(),
                (true, false) => ExitCode::FAILURE,
                (false, _) => code,
            }
        }
    }
}
