//! Execution of a case's run as a user makes it: by the program, in processes of its own.

use super::ValidationError;
use super::case::{Case, CaseRun};
use crate::outputs;
use crate::run::launch::this_program;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;
use tremie_results::Signals;

/// Outputs of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Its signals.
    pub signals: Signals,
    /// Resolution, from its components' descriptions: `fluid: cells` and the like.
    pub resolution: BTreeMap<String, f64>,
    /// Wall time of its windows [s].
    pub wall_time: f64,
}

/// Makes a run, with outputs in a folder of its own in `scratch`.
///
/// # Errors
/// If it fails, or its outputs cannot be read.
pub fn run(
    case: &Case,
    run: &CaseRun,
    short: bool,
    scratch: &Path,
) -> Result<Outcome, ValidationError> {
    let place = case.runs.iter().position(|other| other.name == run.name).unwrap_or(0);
    let out = scratch.join(format!("{}-{place}", case.name));
    let mut command = this_program();
    command.arg("run").arg(case.folder.join(&run.manifest)).arg("--out").arg(&out);
    command.args(["--quiet", "--set", "outputs.record=false"]);
    let shortened = run.short.iter().filter(|_| short).flat_map(|form| &form.set);
    // The changes of the short form come last, and override those of the run.
    for (key, value) in run.set.iter().chain(shortened) {
        command.arg("--set").arg(format!("{key}={value}"));
    }
    let told = command.stdin(Stdio::null()).output().map_err(ValidationError::io(&out))?;
    if !told.status.success() {
        let said = String::from_utf8_lossy(&told.stderr).trim().to_string();
        return Err(ValidationError::Run { run: format!("{}, {}", case.name, run.name), said });
    }
    let (resolution, wall_time) = read_summary(&out.join(outputs::SUMMARY))?;
    Ok(Outcome { signals: Signals::read(&out.join(outputs::SIGNALS))?, resolution, wall_time })
}

fn read_summary(path: &Path) -> Result<(BTreeMap<String, f64>, f64), ValidationError> {
    let text = std::fs::read_to_string(path).map_err(ValidationError::io(path))?;
    let summary: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| ValidationError::content(path, error))?;
    let mut resolution = BTreeMap::new();
    for (name, component) in summary["components"].as_object().into_iter().flatten() {
        for (quantity, value) in component["resolution"].as_object().into_iter().flatten() {
            if let Some(value) = value.as_f64() {
                resolution.insert(format!("{name}: {quantity}"), value);
            }
        }
    }
    Ok((resolution, summary["wall_time"].as_f64().unwrap_or(f64::NAN)))
}
