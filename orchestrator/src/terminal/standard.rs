//! Standard output and standard error, for the whole program.
//!
//! The reader may stop reading, and standard output may go to a file on a full disk. `println!`
//! panics then. A program that ignores the error ends with code 0 although it wrote nothing. So all
//! that the program prints goes through here (a lint sees to it). [`answer`] and [`answer_text`]
//! keep the first failure, and `main` ends with [`ending`]. It ends quietly with [`READER_GONE`]
//! where the reader has gone, else with the system's words and code 1.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};
use std::process::ExitCode;
use std::sync::OnceLock;

/// Exit code of a program whose reader has gone. A shell shows this code for a program that SIGPIPE
/// ended.
pub const READER_GONE: u8 = 141;

/// Error of standard output that ended the answer, if one did.
static LOST: OnceLock<io::Error> = OnceLock::new();

/// Writes a line of a command's answer to standard output.
pub fn answer(line: impl Display) {
    answer_text(format_args!("{line}\n"));
}

/// Writes text of a command's answer to standard output.
pub fn answer_text(text: impl Display) {
    if is_lost() {
        return;
    }
    let mut output = io::stdout().lock();
    // Flushed each time: a pipe's reader sees the line at once, and an error is found here.
    if let Err(error) = output.write_fmt(format_args!("{text}")).and_then(|()| output.flush()) {
        let _ = LOST.set(error);
    }
}

/// True if standard output takes no more: a command that works only for its answer may stop.
pub fn is_lost() -> bool {
    LOST.get().is_some()
}

/// Writes a line to standard error. A failure has no place where it could be reported.
pub fn complain(line: impl Display) {
    complain_text(format_args!("{line}\n"));
}

/// Writes text to standard error.
pub fn complain_text(text: impl Display) {
    // In one piece: lines of other processes on the same terminal do not get between.
    let _ = io::stderr().write_all(text.to_string().as_bytes());
}

/// The exit code of a command that would end with `code`, had standard output taken all of its
/// answer.
pub fn ending(code: ExitCode) -> ExitCode {
    // The last bytes may still be in the buffer, and fail only now.
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
