//! The `tremie` program.

#![warn(clippy::print_stdout, clippy::print_stderr)]

use std::process::ExitCode;
use tremie::program::cli::{self, Asked, Command};
use tremie::program::commands;
use tremie::run::limits;
use tremie::terminal::standard;

fn main() -> ExitCode {
    // First: components inherit the limit of open files.
    limits::widen();
    let code = match cli::read() {
        Ok(Asked::Own(command)) => obey(command),
        Ok(Asked::OfPackage(work, arguments)) => commands::of_package(work, &arguments),
        Ok(Asked::Reader(work, out, arguments)) => commands::reader(work, &out, &arguments),
        Err(word) => commands::usage(&word),
    };
    // Last: output that could not be written must not end with code 0.
    standard::ending(code)
}

fn obey(command: Command) -> ExitCode {
    match command {
        Command::Run(arguments) => commands::run(&arguments),
        Command::Resume(arguments) => commands::resume(&arguments),
        Command::Check(arguments) => commands::check(&arguments),
        Command::Signals(arguments) => commands::signals(&arguments),
        Command::Components => commands::components(),
        Command::View(arguments) => commands::view(&arguments),
        Command::Diff(arguments) => commands::diff(&arguments),
        Command::Replay(arguments) => commands::replay(&arguments),
        Command::Report(arguments) => commands::report(&arguments),
        Command::Bench(arguments) => commands::bench(&arguments),
        Command::Conform(arguments) => commands::conform(&arguments),
        Command::Study(arguments) => commands::study(&arguments),
        Command::Validate(arguments) => commands::validate(&arguments),
        Command::Steer(command) => commands::steer(command),
        Command::Clean => commands::clean(),
        Command::Schema { markdown } => commands::schema(markdown),
        Command::Explain { key } => commands::explain(&key),
        Command::Component { name } => commands::component(&name),
    }
}
