//! `tremie signals`: names, units and meanings of the signals that a run will report.

use super::run::{folder_of, style};
use super::{interrupts::count_interrupts, refuse, refuse_text};
use crate::manifest::{self, Manifest};
use crate::program::cli::ManifestArgs;
use crate::run::{Execution, RunError, prepare};
use crate::terminal::Terminal;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use tremie_messages::start::Signal;
use tremie_results::text_columns;

/// Lists the signals of a manifest's components: name, unit, meaning.
pub fn signals(arguments: &ManifestArgs) -> ExitCode {
    let mut terminal = Terminal::answering(style(arguments));
    let manifest = match manifest::load(&arguments.manifest, &arguments.sets()) {
        Ok(manifest) => manifest,
        Err(errors) => return refuse_text(&errors, arguments.json, &terminal),
    };
    match list(&manifest, &arguments.manifest) {
        Ok(signals) => {
            tell(&signals, &terminal);
            ExitCode::SUCCESS
        }
        Err(error) => refuse(&error, &manifest, arguments.json, &mut terminal),
    }
}

/// All signals, with the components that report them.
fn list(manifest: &Manifest, path: &Path) -> Result<Vec<(String, Signal)>, RunError> {
    let interrupts = count_interrupts().map_err(RunError::Signals)?;
    let folder = folder_of(path);
    let prepared = prepare(manifest, &folder, Path::new(""), &Execution::default(), &interrupts)?;
    let of = |(name, signals): (&String, &Vec<Signal>)| {
        signals.iter().map(|signal| (name.clone(), signal.clone())).collect::<Vec<_>>()
    };
    let names: Vec<String> = prepared.peers.iter().map(|peer| peer.name.clone()).collect();
    let signals: Vec<_> = prepared.descriptions.iter().map(|d| d.signals.clone()).collect();
    prepared.dismiss();
    Ok(names.iter().zip(&signals).flat_map(of).collect())
}

fn tell(signals: &[(String, Signal)], terminal: &Terminal) {
    let row = |(component, signal): &(String, Signal)| {
        let Signal { name, unit, meaning, .. } = signal;
        vec![format!("{component}.{name}"), unit.clone(), meaning.clone()]
    };
    if !terminal.speaks_json() {
        for line in text_columns(&["signal", "unit", "meaning"], signals.iter().map(row).collect())
        {
            terminal.say(&line);
        }
    }
    let document = |(component, signal): &(String, Signal)| json!({"component": component, "name": signal.name, "unit": signal.unit, "meaning": signal.meaning});
    let all: Vec<_> = signals.iter().map(document).collect();
    terminal.event(json!({"event": "signals", "signals": all}));
}
