//! Commands of a few lines.

use crate::manifest::{self, KeyHelp};
use crate::registry::{BUILT_IN, built_in};
use crate::terminal::standard::{answer, answer_text, complain};
use crate::tools::conform::ConformArgs;
use std::process::ExitCode;
use tremie_sdk::main_of;

/// `tremie components`: the built-in components and their roles.
pub fn components() -> ExitCode {
    for component in BUILT_IN {
        let (name, role) = (component.name, component.role.name());
        answer(format_args!("{name:<12} {role:<10} {}", component.about));
    }
    answer("\nAny other program can take a role: name it, or its path, in the [components] table.");
    ExitCode::SUCCESS
}

/// `tremie component NAME`: takes part in a run; the orchestrator calls this.
pub fn component(name: &str) -> ExitCode {
    match built_in(name) {
        Some(component) => main_of(component.name, component.role.name(), component.run),
        None => {
            complain(format_args!("error: there is no built-in component \"{name}\""));
            ExitCode::from(super::WRONG_INPUT)
        }
    }
}

/// `tremie clean`: removes shared memory and folders that killed runs left.
pub fn clean() -> ExitCode {
    match tremie_channels::sweep::sweep_dead_runs() {
        Ok(0) => answer("nothing to clean"),
        Ok(runs) => answer(format_args!("removed what {runs} killed runs had left")),
        Err(error) => {
            complain(format_args!("error: {error}"));
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

/// `tremie schema`: the JSON schema of the manifest, or its reference page.
pub fn schema(markdown: bool) -> ExitCode {
    match markdown {
        true => answer_text(manifest::reference_page()),
        false => answer(manifest::schema_text()),
    }
    ExitCode::SUCCESS
}

/// `tremie explain KEY`: what a key of the manifest is, or all keys of that name.
pub fn explain(key: &str) -> ExitCode {
    let found = match manifest::key_help(key) {
        Ok(found) => found,
        Err(error) => {
            complain(format_args!("error: {error}"));
            return ExitCode::from(super::WRONG_INPUT);
        }
    };
    for KeyHelp { path, kind, meaning, keys } in &found {
        answer(path);
        answer(format_args!("  {kind}"));
        if !meaning.is_empty() {
            answer(format_args!("  {meaning}"));
        }
        let width = keys.iter().map(|key| key[0].len()).max().unwrap_or(0);
        for [name, kind, meaning] in keys {
            answer(format_args!("    {name:<width$}  {kind}. {meaning}"));
        }
    }
    ExitCode::SUCCESS
}

/// `tremie conform PROGRAM`.
pub fn conform(arguments: &ConformArgs) -> ExitCode {
    crate::tools::conform::conform(arguments)
}
