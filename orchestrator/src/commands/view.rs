//! `tremie view OUT`: opens a finished run.

use crate::cli::ViewArgs;
use std::process::ExitCode;

/// `tremie view OUT`.
pub fn view(_arguments: &ViewArgs) -> ExitCode {
    ExitCode::FAILURE
}
