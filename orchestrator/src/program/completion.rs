//! Completion of command lines in a shell: the script that a shell reads, and the program's answers to it.
//!
//! The script asks the program itself, so that it knows the keys of manifests, templates and files, and never
//! falls behind the program. It sets `VARIABLE` to the shell's name and gives the words typed after `--`.

use super::cli::whole;
use crate::manifest::keys_beginning;
use crate::terminal::standard::{answer_text, complain};
use clap::ValueEnum;
use clap_complete::engine::CompletionCandidate;
use clap_complete::env::Shells;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

/// Variable of the environment by which a script asks.
const VARIABLE: &str = "TREMIE_COMPLETE";
/// Name of the program on command lines.
const PROGRAM: &str = "tremie";

/// A shell that completes command lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CompletionShell {
    /// Bash.
    Bash,
    /// Z shell.
    Zsh,
    /// Fish.
    Fish,
}

impl CompletionShell {
    fn name(self) -> &'static str {
        match self {
            Self::Bash => "bash",
            Self::Zsh => "zsh",
            Self::Fish => "fish",
        }
    }
}

/// `tremie completions SHELL`: the script for a shell. `own_name` is the program's name, as the shell called it.
pub fn completions(shell: CompletionShell, own_name: Option<OsString>) -> ExitCode {
    match script(shell, &program(own_name)) {
        Ok(script) => {
            answer_text(script);
            ExitCode::SUCCESS
        }
        Err(error) => {
            complain(format_args!("error: no script for {}: {error}", shell.name()));
            ExitCode::FAILURE
        }
    }
}

/// The program as a script shall call it: by its name where the shell found it so, else by its whole path.
fn program(first: Option<OsString>) -> String {
    let first = first.unwrap_or_else(|| PROGRAM.into());
    let path = Path::new(&first);
    let called = match path.components().count() {
        0 | 1 => first,
        _ => std::path::absolute(path).map_or(first, Into::into),
    };
    called.to_string_lossy().into_owned()
}

fn script(shell: CompletionShell, program: &str) -> std::io::Result<String> {
    let shells = Shells::builtins();
    let unknown = || std::io::Error::other("the library does not know this shell");
    let completer = shells.completer(shell.name()).ok_or_else(unknown)?;
    let mut script = Vec::new();
    completer.write_registration(VARIABLE, PROGRAM, PROGRAM, program, &mut script)?;
    Ok(String::from_utf8_lossy(&script).into_owned())
}

/// Answers a script's question, if the command line is one.
pub fn answer_script(words: &[OsString]) -> Option<ExitCode> {
    let shell = std::env::var_os(VARIABLE)?;
    let typed = words.get(1).filter(|word| *word == "--").and(words.get(2..))?;
    match answer_to(&shell, typed) {
        Some(text) => {
            answer_text(text);
            Some(ExitCode::SUCCESS)
        }
        // A shell then shows nothing.
        None => Some(ExitCode::FAILURE),
    }
}

fn answer_to(shell: &OsStr, typed: &[OsString]) -> Option<String> {
    let shells = Shells::builtins();
    let completer = shells.completer(shell.to_str()?)?;
    if typed.is_empty() {
        return None;
    }
    let folder = std::env::current_dir().ok();
    let mut answer = Vec::new();
    completer.write_complete(&mut whole(), typed.to_vec(), folder.as_deref(), &mut answer).ok()?;
    Some(String::from_utf8_lossy(&answer).into_owned())
}

/// Keys of a manifest for KEY=VALUE, as far as they are typed.
pub fn complete_setting(typed: &OsStr) -> Vec<CompletionCandidate> {
    // A value is the user's.
    let typed = typed.to_str().filter(|typed| !typed.contains('='));
    let keys = typed.map(keys_beginning).unwrap_or_default();
    keys.into_iter()
        .map(|key| CompletionCandidate::new(key.text).help(Some(key.kind.into())))
        .collect()
}

/// Keys of a manifest for `tremie explain`.
pub fn complete_key(typed: &OsStr) -> Vec<CompletionCandidate> {
    let keys = typed.to_str().map(keys_beginning).unwrap_or_default();
    let mut names: Vec<(String, String)> = keys
        .into_iter()
        .map(|key| {
            let name = key.text.trim_end_matches(['=', '.']).trim_end_matches("[0]");
            (name.to_string(), key.kind)
        })
        .collect();
    names.dedup_by(|a, b| a.0 == b.0);
    names
        .into_iter()
        .map(|(name, kind)| CompletionCandidate::new(name).help(Some(kind.into())))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Candidates, as a shell that wants one a line gets them.
    fn candidates(words: &[&str]) -> Vec<String> {
        let typed: Vec<OsString> = words.iter().map(OsString::from).collect();
        let text = answer_to(OsStr::new("fish"), &typed).unwrap();
        text.lines().map(|line| line.split('\t').next().unwrap_or("").to_string()).collect()
    }

    #[test]
    fn commands_and_options_are_completed() {
        let commands = candidates(&["tremie", "ne"]);
        assert_eq!(commands, ["new"]);
        assert!(candidates(&["tremie", ""]).contains(&"valve".to_string()), "a package's command");
        assert!(!candidates(&["tremie", ""]).contains(&"component".to_string()), "hidden");
        assert!(candidates(&["tremie", "run", "--unt"]).contains(&"--until".to_string()));
        assert_eq!(candidates(&["tremie", "completions", "z"]), ["zsh"]);
        assert_eq!(candidates(&["tremie", "new", "x", "--from", "dam"]), ["dam-break"]);
    }

    #[test]
    fn keys_are_completed_wherever_a_value_is_set() {
        for command in ["run", "check", "resume", "replay"] {
            let found = candidates(&["tremie", command, "x", "--set", "scene.fluid.visc"]);
            assert_eq!(found, ["scene.fluid.viscosity="], "{command}");
        }
        assert_eq!(candidates(&["tremie", "set", "run.unt"]), ["run.until="]);
        assert_eq!(candidates(&["tremie", "explain", "run.unt"]), ["run.until"]);
        assert!(candidates(&["tremie", "run", "--set", "run.until=2"]).is_empty());
    }

    #[test]
    fn scripts_ask_the_program() {
        for shell in [CompletionShell::Bash, CompletionShell::Zsh, CompletionShell::Fish] {
            let script = script(shell, "/opt/tremie").unwrap();
            assert!(script.contains(VARIABLE) && script.contains("/opt/tremie"), "{script}");
        }
        assert_eq!(program(Some("tremie".into())), "tremie");
        assert_eq!(program(Some("/opt/tremie".into())), "/opt/tremie");
    }
}
