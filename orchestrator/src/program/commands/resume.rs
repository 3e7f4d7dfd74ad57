//! `tremie resume`: goes on with a run from a checkpoint.

use super::at_slurm::SlurmOrder;
use super::carry_out::{Begin, RunOrder, add_observers, carry_out};
use super::{WRONG_INPUT, refuse, refuse_text};
use crate::outputs::{ChangeRecord, RunFolder, WholeCheckpoint, record_change};
use crate::program::cli::ResumeArgs;
use crate::program::run_words::resume_words;
use crate::run::Execution;
use crate::run::changes::{self, NotChanged};
use crate::terminal::{Style, Terminal};
use std::process::ExitCode;

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
    let file = from.manifest_file();
    let mut manifest = match changes::changed(&file, &from.manifest, &sets(arguments)) {
        Ok(manifest) => manifest,
        Err(NotChanged::Wrong(errors)) => return refuse_text(&errors, arguments.json, &terminal),
        Err(error) => {
            terminal.fail(&error.to_string());
            return ExitCode::from(WRONG_INPUT);
        }
    };
    add_observers(&mut manifest, &arguments.view);
    let execution = Execution { in_process: arguments.in_process, ..Execution::default() };
    let programs = from.record.programs.clone();
    if arguments.at_slurm.slurm {
        let order = SlurmOrder {
            manifest: &manifest,
            programs: &programs,
            execution,
            view: &arguments.view,
            at_slurm: &arguments.at_slurm,
        };
        let claim = || RunFolder::reclaim(&arguments.out);
        let given = order.carry_out(&mut terminal, claim, |_| resume_words(arguments));
        return given
            .unwrap_or_else(|error| refuse(&error, &manifest, arguments.json, &mut terminal));
    }
    let order = RunOrder {
        manifest: &manifest,
        programs: &programs,
        view: &arguments.view,
        is_quiet: arguments.quiet,
        restarts: arguments.restart_on_fault,
        changes: &[],
    };
    let change = ChangeRecord { window: from.record.window, set: sets(arguments) };
    let before = from.manifest.clone();
    let claim = || {
        let folder = RunFolder::reclaim(&arguments.out)?;
        if !change.set.is_empty() {
            record_change(folder.path(), &before, &change)?;
        }
        Ok(folder)
    };
    match carry_out(&order, execution, Some(Begin::goes_on(from)), &mut terminal, claim) {
        Ok(code) => code,
        Err(error) => refuse(&error, &manifest, arguments.json, &mut terminal),
    }
}

/// All changes to the manifest's values; a later one overrides an earlier one.
fn sets(arguments: &ResumeArgs) -> Vec<(String, String)> {
    let until = arguments.until.iter().map(|until| ("run.until".to_string(), until.clone()));
    until.chain(arguments.set.iter().cloned()).collect()
}
