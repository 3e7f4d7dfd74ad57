//! The `tremie` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    tremie::program::main(std::env::args_os())
}
