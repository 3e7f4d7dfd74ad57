//! The `tremie` program.

#![warn(clippy::print_stdout, clippy::print_stderr)]

use clap::Parser;
use std::process::ExitCode;
use tremie::cli::{Cli, Command};
use tremie::{commands, limits, standard};

fn main() -> ExitCode {
    limits::widen();
    let code = match Cli::try_parse() {
        Ok(cli) => obey(cli.command),
        Err(word) => commands::usage(&word),
    };
    standard::ending(code)
}

fn obey(command: Command) -> ExitCode {
    match command {
        Command::Run(arguments) => commands::run(&arguments),
        Command::Check(arguments) => commands::check(&arguments),
        Command::Signals(arguments) => commands::signals(&arguments),
        Command::Components => commands::components(),
        Command::View(arguments) => commands::view(&arguments),
        Command::Report(arguments) => commands::report(&arguments),
        Command::Bench(arguments) => commands::bench(&arguments),
        Command::Valve(arguments) => commands::valve(&arguments),
        Command::Conform(arguments) => commands::conform(&arguments),
        Command::Validate(arguments) => commands::validate(&arguments),
        Command::Scene(arguments) => commands::scene(&arguments),
        Command::Rubber(command) => commands::rubber(&command),
        Command::Clean => commands::clean(),
        Command::Schema => commands::schema(),
        Command::Component { name } => commands::component(&name),
    }
}
