//! `tremie resume`: goes on with a run from a checkpoint.

use super::run::{RunOrder, add_observers, carry_out};
use super::{WRONG_INPUT, refuse, refuse_text};
use crate::manifest::{self, Manifest};
use crate::outputs::{RunFolder, WholeCheckpoint};
use crate::program::cli::ResumeArgs;
use crate::run::Execution;
use crate::terminal::{Style, Terminal};
use std::process::ExitCode;

/// Keys of the manifest that may change where a run goes on, and all below them: none of them is part of
/// a state.
const MAY_CHANGE: [&str; 7] = [
    "run.until",
    "run.deadline",
    "run.start_within",
    "run.checkpoints",
    "outputs",
    "stop_when",
    "watch",
];

/// `tremie resume`.
pub fn resume(arguments: &ResumeArgs) -> ExitCode {
    let mut terminal = Terminal::new(Style::asked(arguments.quiet, arguments.json));
    let from = match WholeCheckpoint::find(&arguments.out, arguments.at) {
        Ok(from) => from,
        Err(error) => {
            terminal.fail(&error.to_string());
            return ExitCode::from(WRONG_INPUT);
        }
    };
    let mut manifest = match read(&from, &sets(arguments)) {
        Ok(manifest) => manifest,
        Err(errors) => return refuse_text(&errors, arguments.json, &terminal),
    };
    if let Some(text) = forbidden(&from, &manifest) {
        terminal.fail(&text);
        return ExitCode::from(WRONG_INPUT);
    }
    add_observers(&mut manifest, &arguments.view);
    let execution = Execution { in_process: arguments.in_process, ..Execution::default() };
    let programs = from.record.programs.clone();
    let order = RunOrder {
        manifest: &manifest,
        programs: &programs,
        view: &arguments.view,
        is_quiet: arguments.quiet,
        restarts: arguments.restart_on_fault,
    };
    let claim = || RunFolder::reclaim(&arguments.out);
    match carry_out(&order, execution, Some(from), &mut terminal, claim) {
        Ok(code) => code,
        Err(error) => refuse(&error, &manifest, arguments.json, &mut terminal),
    }
}

/// All changes to the manifest's values; a later one overrides an earlier one.
fn sets(arguments: &ResumeArgs) -> Vec<(String, String)> {
    let until = arguments.until.iter().map(|until| ("run.until".to_string(), until.clone()));
    until.chain(arguments.set.iter().cloned()).collect()
}

/// The manifest of the checkpoint's run, with changes.
fn read(
    from: &WholeCheckpoint,
    sets: &[(String, String)],
) -> Result<Manifest, manifest::ManifestErrors> {
    let file = from.folder().join(crate::outputs::MANIFEST);
    manifest::parse(&file, from.manifest.clone(), sets)
}

/// Why the changes to the manifest of a checkpoint cannot be; `None` if they can.
fn forbidden(from: &WholeCheckpoint, changed: &Manifest) -> Option<String> {
    let before = read(from, &[]).ok()?;
    let differing = manifest::differences(&before, changed);
    let may = |key: &String| {
        let is_threads = key.starts_with("components.") && key.ends_with(".threads");
        is_threads || MAY_CHANGE.iter().any(|known| is_within(key, known))
    };
    let wrong: Vec<_> = differing.into_iter().filter(|key| !may(key)).collect();
    if wrong.is_empty() {
        return None;
    }
    Some(format!(
        "{} cannot change where a run goes on, because states depend on it; what can: {}, threads of components",
        wrong.join(", "),
        MAY_CHANGE.join(", ")
    ))
}

/// True if a key is another, or lies below it.
fn is_within(key: &str, above: &str) -> bool {
    key.strip_prefix(above).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_lies_within_its_tables_only() {
        assert!(is_within("outputs.frames", "outputs") && is_within("outputs", "outputs"));
        assert!(is_within("stop_when[0].above", "stop_when"));
        assert!(!is_within("outputs_of", "outputs") && !is_within("run", "run.until"));
    }
}
