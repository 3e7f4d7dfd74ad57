//! The program: its command line, and each of its commands.

pub mod cli;
pub mod commands;
pub mod completion;
pub mod run_words;
pub mod slurm_args;
pub mod steer_args;

use crate::run::limits;
use crate::terminal::standard;
use cli::{Asked, Command};
use std::ffi::OsString;
use std::process::ExitCode;

/// The whole `main` of the program: does what a command line asks for. Its first word is the program's
/// name.
pub fn main(words: impl IntoIterator<Item = OsString>) -> ExitCode {
    // First: components inherit the limit of open files.
    limits::widen();
    let words: Vec<OsString> = words.into_iter().collect();
    if let Some(code) = completion::answer_script(&words) {
        return standard::ending(code);
    }
    let own_name = words.first().cloned();
    let code = match cli::read(words) {
        Ok(Asked::Own(command)) => obey(*command, own_name),
        Ok(Asked::OfPackage(work, arguments)) => commands::of_package(work, &arguments),
        Ok(Asked::Reader(work, out, arguments)) => commands::reader(work, &out, &arguments),
        Err(word) => commands::usage(&word),
    };
    // Last: output that could not be written must not end with code 0.
    standard::ending(code)
}

fn obey(command: Command, own_name: Option<OsString>) -> ExitCode {
    match command {
        Command::New(arguments) => commands::new_scene(&arguments),
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
        Command::Completions { shell } => completion::completions(shell, own_name),
        Command::Component { name } => commands::component(&name),
    }
}
