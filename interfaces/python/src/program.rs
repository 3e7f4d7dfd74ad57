//! The `tremie` program, as the package carries it.

use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;
use tremie::run::launch::{Interpreted, interpreted_by};

/// Does what a command line of `tremie` asks for, and gives its exit code. `interpreter` and `script` are how
/// this program is started again.
#[pyfunction]
pub fn program(
    py: Python<'_>,
    arguments: Vec<OsString>,
    interpreter: PathBuf,
    script: PathBuf,
) -> u8 {
    interpreted_by(Interpreted { interpreter, script });
    let words = std::iter::once(OsString::from("tremie")).chain(arguments);
    py.detach(|| number(tremie::program::main(words)))
}

/// The number of an exit code, which the standard library keeps to itself.
pub fn number(code: ExitCode) -> u8 {
    (0..=u8::MAX).find(|number| ExitCode::from(*number) == code).unwrap_or(1)
}
