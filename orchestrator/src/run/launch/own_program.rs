//! This program, as it starts itself again: for a component that it carries, or for a run of its own.
//!
//! It is an executable as a rule. The Python package carries it in a module; then an interpreter and
//! its script are the program.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Interpreter that runs programs of Python where this program is none itself.
const PYTHON: &str = "python3";

/// An interpreter and the script by which this program was started.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interpreted {
    /// Path of the interpreter.
    pub interpreter: PathBuf,
    /// Path of the script, which hands its arguments to [`crate::program::main`].
    pub script: PathBuf,
}

static INTERPRETED: OnceLock<Interpreted> = OnceLock::new();

/// Says that this program is a script. Must come first, and counts once.
pub fn interpreted_by(own: Interpreted) {
    let _ = INTERPRETED.set(own);
}

/// This very executable, even if its file was replaced since the program began; or the script.
pub(crate) fn own_command() -> Command {
    let Some(own) = INTERPRETED.get() else { return Command::new("/proc/self/exe") };
    let mut command = Command::new(&own.interpreter);
    command.arg(&own.script);
    command
}

/// Words of a command line that begin with this program, for a later time.
///
/// # Errors
/// If the system does not tell the executable's path.
pub fn own_words() -> io::Result<Vec<OsString>> {
    match INTERPRETED.get() {
        Some(own) => Ok(vec![own.interpreter.clone().into(), own.script.clone().into()]),
        None => Ok(vec![std::env::current_exe()?.into()]),
    }
}

/// Folder of this program, where its fellow programs lie: that of the interpreter of a script.
pub(crate) fn own_folder() -> Option<PathBuf> {
    let own = match INTERPRETED.get() {
        Some(own) => own.interpreter.clone(),
        None => std::env::current_exe().ok()?,
    };
    own.parent().map(Path::to_path_buf)
}

/// The command that runs a component's program: a file whose name ends in `.py` by Python, by the one that
/// runs this program if one does.
pub(crate) fn command_of(file: &Path) -> Command {
    if file.extension().is_none_or(|end| end != "py") {
        return Command::new(file);
    }
    let python = INTERPRETED.get().map_or(Path::new(PYTHON), |own| &own.interpreter);
    let mut command = Command::new(python);
    command.arg(file);
    command
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_of_python_is_run_by_python_and_any_other_by_itself() {
        let python = command_of(Path::new("/a/drag.py"));
        assert_eq!(python.get_program(), PYTHON);
        assert_eq!(python.get_args().collect::<Vec<_>>(), ["/a/drag.py"]);
        let other = command_of(Path::new("/a/drag"));
        assert_eq!((other.get_program(), other.get_args().count()), ("/a/drag".as_ref(), 0));
    }
}
