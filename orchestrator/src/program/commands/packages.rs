//! Commands that packages add.

use super::WRONG_INPUT;
use crate::manifest;
use crate::outputs::SCENE;
use crate::registry::{OnArguments, OnRuns};
use crate::terminal::standard::{answer_text, complain, complain_text};
use crate::tools::study::done_runs;
use clap::ArgMatches;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use tremie_messages::scene::Scene;
use tremie_results::{CommandError, FinishedRun, signals_of};

/// A command on arguments alone.
pub fn of_package(work: OnArguments, arguments: &ArgMatches) -> ExitCode {
    end(work(arguments))
}

/// A reader of the finished runs in folders, each of a run or of a study.
pub fn reader(work: OnRuns, out: &[PathBuf], arguments: &ArgMatches) -> ExitCode {
    let of = |folder: &PathBuf| done_runs(folder).unwrap_or_else(|| vec![folder.clone()]);
    let folders = out.iter().flat_map(of);
    let runs = folders.map(|folder| finished(&folder)).collect::<Result<Vec<_>, _>>();
    end(runs.map_err(CommandError::input).and_then(|runs| work(&runs, arguments)))
}

fn finished(out: &Path) -> Result<FinishedRun, String> {
    let signals = signals_of(out).map_err(|error| error.to_string())?;
    if let Some(cut) = &signals.cut {
        complain(format_args!("warning: {cut}"));
    }
    Ok(FinishedRun { folder: out.to_path_buf(), signals, scene: scene_of(out)? })
}

/// The scene that a run was given. Of a run without one, or with one of another version, that of its manifest.
fn scene_of(out: &Path) -> Result<Scene, String> {
    let path = out.join(SCENE);
    match std::fs::read_to_string(&path).and_then(|text| Ok(serde_json::from_str(&text)?)) {
        Ok(scene) => return Ok(scene),
        Err(error) if error.kind() == ErrorKind::NotFound => {}
        Err(error) => complain(format_args!(
            "warning: cannot read {}: {error}; the scene of the manifest is taken",
            path.display()
        )),
    }
    let manifest = manifest::load(out, &[]).map_err(|errors| errors.to_string())?;
    Ok(manifest.spec.scene)
}

/// Gives the answer of a command, or its error.
pub(super) fn end(done: Result<String, CommandError>) -> ExitCode {
    match done {
        Ok(answer) => {
            answer_text(answer);
            ExitCode::SUCCESS
        }
        Err(CommandError::Input(wrong)) => {
            wrong.iter().for_each(|line| complain(format_args!("error: {line}")));
            WRONG_INPUT.into()
        }
        Err(CommandError::Explained(text)) => {
            complain_text(format_args!("{}\n", text.trim_end()));
            WRONG_INPUT.into()
        }
        Err(CommandError::Failed(why)) => {
            complain(format_args!("error: {why}"));
            ExitCode::FAILURE
        }
    }
}
