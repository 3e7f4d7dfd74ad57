//! `tremie signals`: names, units and meanings of the signals that a run will report.

use super::run::{folder_of, style};
use super::{interrupts::count_interrupts, refuse, refuse_text};
use crate::manifest;
use crate::program::cli::ManifestArgs;
use crate::run::{RunError, signals_of};
use crate::terminal::Terminal;
use serde_json::json;
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
    let listed = count_interrupts()
        .map_err(RunError::Signals)
        .and_then(|count| signals_of(&manifest, &folder_of(&arguments.manifest), &count));
    match listed {
        Ok(signals) => {
            tell(&signals, &terminal);
            ExitCode::SUCCESS
        }
        Err(error) => refuse(&error, &manifest, arguments.json, &mut terminal),
    }
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
