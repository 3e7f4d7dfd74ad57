//! `tremie run`.

use super::at_slurm::SlurmOrder;
use super::carry_out::{Begin, RunOrder, add_observers, carry_out};
use super::{refuse, refuse_text};
use crate::manifest::{self, Manifest};
use crate::outputs::{self, ChangeRecord, RunFolder, WholeCheckpoint};
use crate::program::cli::{ManifestArgs, RunArgs};
use crate::program::run_words::run_words;
use crate::run::{Execution, RunError, changes};
use crate::terminal::{Style, Terminal};
use crate::tools::study::RunNames;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tremie_messages::Problem;

/// `tremie run`.
pub fn run(arguments: &RunArgs) -> ExitCode {
    let mut terminal = Terminal::new(style(&arguments.manifest));
    let json = arguments.manifest.json;
    let mut manifest =
        match manifest::load(&arguments.manifest.manifest, &arguments.manifest.sets()) {
            Ok(manifest) => manifest,
            Err(errors) => return refuse_text(&errors, json, &terminal),
        };
    add_observers(&mut manifest, &arguments.view);
    match run_checked(&manifest, arguments, &mut terminal) {
        Ok(code) => code,
        Err(error) => refuse(&error, &manifest, json, &mut terminal),
    }
}

fn run_checked(
    manifest: &Manifest,
    arguments: &RunArgs,
    terminal: &mut Terminal,
) -> Result<ExitCode, RunError> {
    if let Some(content) = &arguments.content {
        check_content(content, manifest)?;
    }
    let planned = planned_changes(arguments.changes.as_deref(), manifest)?;
    let execution = Execution {
        in_process: arguments.in_process,
        inject: arguments.inject.clone(),
        trace: arguments.trace.clone(),
        pause_at: arguments.pause_at,
        changes: planned.clone(),
        ..Execution::default()
    };
    let folder = folder_of(&arguments.manifest.manifest);
    let order = RunOrder {
        manifest,
        programs: &folder,
        view: &arguments.view,
        is_quiet: arguments.manifest.quiet,
        restarts: arguments.restart_on_fault,
        changes: &planned,
    };
    let from = match &arguments.from {
        None => None,
        Some(from) => Some(branch(from, manifest)?),
    };
    let out = arguments.out.as_deref();
    if arguments.at_slurm.slurm {
        let order = SlurmOrder {
            manifest,
            programs: &folder,
            execution,
            view: &arguments.view,
            at_slurm: &arguments.at_slurm,
        };
        let claim = || RunFolder::choose(out, &arguments.manifest.manifest);
        return order.carry_out(terminal, claim, |out| run_words(arguments, out));
    }
    let claim = || match out {
        Some(out) if arguments.in_job => RunFolder::claim_in_job(out),
        out => RunFolder::choose(out, &arguments.manifest.manifest),
    };
    carry_out(&order, execution, from, terminal, claim)
}

/// Checks that a manifest and its files have the content that a study planned.
fn check_content(content: &str, manifest: &Manifest) -> Result<(), RunError> {
    if RunNames::default().of(&manifest.resolved()).content == content {
        return Ok(());
    }
    let message =
        "the manifest, or a file that it names, has changed since the study planned this run";
    let problem = Problem::new("--content", message);
    Err(RunError::Input(vec![problem.help("start the study again: it plans its runs anew")]))
}

/// The changes in a file, each tried on the manifest that the ones before it leave.
fn planned_changes(
    file: Option<&Path>,
    manifest: &Manifest,
) -> Result<Vec<ChangeRecord>, RunError> {
    let Some(path) = file else { return Ok(Vec::new()) };
    let wrong = |text: String| RunError::Input(vec![Problem::new("--changes", text)]);
    let planned = outputs::read_changes(path).map_err(wrong)?;
    let (file, mut text) = (Path::new(manifest.source.file()), manifest.resolved());
    for ChangeRecord { window, set } in &planned {
        let changed = changes::changed(file, &text, set)
            .map_err(|error| wrong(format!("the change of window {window}: {error}")))?;
        text = changed.resolved();
    }
    Ok(planned)
}

/// The checkpoint of another run from which a run of `manifest` shall begin.
fn branch((out, window): &(PathBuf, Option<u64>), manifest: &Manifest) -> Result<Begin, RunError> {
    let wrong = |text: String| RunError::Input(vec![Problem::new("--from", text)]);
    let checkpoint =
        WholeCheckpoint::find(out, *window).map_err(|error| wrong(error.to_string()))?;
    let takes = changes::branch(&checkpoint.manifest_file(), &checkpoint.manifest, manifest)
        .map_err(|error| wrong(error.to_string()))?;
    Ok(Begin { checkpoint, takes })
}

pub(super) fn style(arguments: &ManifestArgs) -> Style {
    Style::asked(arguments.quiet, arguments.json)
}

/// The folder from which a manifest's programs are found.
pub(super) fn folder_of(manifest: &Path) -> PathBuf {
    if manifest.is_dir() {
        manifest.to_path_buf()
    } else {
        manifest.parent().map(Path::to_path_buf).unwrap_or_default()
    }
}
