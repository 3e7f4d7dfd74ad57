//! The `tremie` program, as the package carries it.

use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;
use tremie::run::launch::{Interpreted, interpreted_by};
use tremie_sdk::number_of;

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
    py.detach(|| number_of(tremie::program::main(words)))
}
