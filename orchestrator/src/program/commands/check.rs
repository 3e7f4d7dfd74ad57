//! `tremie check`, and what it and a run show of the plan.

use super::carry_out::add_observers;
use super::interrupts::count_interrupts;
use super::run::{folder_of, style};
use super::{refuse, refuse_text};
use crate::manifest::{self, Manifest};
use crate::outputs::JudgedFinding;
use crate::preflight;
use crate::program::cli::{CheckArgs, View};
use crate::run::{Execution, Prepared, RunError, measured_time, prepare};
use crate::terminal::Terminal;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;
use tremie_messages::Verdict;

/// `tremie check`: everything up to the plan, and the findings on its numbers.
pub fn check(arguments: &CheckArgs) -> ExitCode {
    let mut terminal = Terminal::answering(style(&arguments.manifest));
    let json = arguments.manifest.json;
    let mut manifest =
        match manifest::load(&arguments.manifest.manifest, &arguments.manifest.sets()) {
            Ok(manifest) => manifest,
            Err(errors) => return refuse_text(&errors, json, &terminal),
        };
    add_observers(&mut manifest, &View::None);
    match check_components(&manifest, arguments, &terminal) {
        Ok(wrong) => ExitCode::from(u8::from(wrong > 0)),
        Err(error) => refuse(&error, &manifest, json, &mut terminal),
    }
}

/// The number of findings that are wrong.
fn check_components(
    manifest: &Manifest,
    arguments: &CheckArgs,
    terminal: &Terminal,
) -> Result<usize, RunError> {
    let interrupts = count_interrupts().map_err(RunError::Signals)?;
    let folder = folder_of(&arguments.manifest.manifest);
    let execution = Execution::default();
    let mut prepared = prepare(manifest, &folder, Path::new(""), &execution, &interrupts)?;
    if arguments.measure {
        let windows = prepared.plan.windows;
        let time = measured_time::wall_time(manifest, &folder, windows, &interrupts)?;
        prepared.findings.extend(time);
    }
    show_plan(manifest, &prepared, terminal);
    let wrong = preflight::count(&prepared.findings, Verdict::Wrong);
    // The components wait for an assignment: they are ended in good order.
    prepared.dismiss();
    Ok(wrong)
}

pub(super) fn show_plan(manifest: &Manifest, prepared: &Prepared, terminal: &Terminal) {
    let lines = prepared.plan.lines();
    for line in lines.iter().chain(&manifest.notes) {
        terminal.say(line);
    }
    for warning in &prepared.plan.warnings {
        terminal.warn(warning);
    }
    if !terminal.speaks_json() {
        show_findings(&prepared.findings, terminal);
    }
    terminal.event(json!({
        "event": "plan",
        "plan": prepared.plan.document(),
        "lines": lines,
        "notes": manifest.notes,
        "warnings": prepared.plan.warnings,
        "findings": prepared.findings,
    }));
}

/// Shows a table of all findings, and sentences about doubtful and wrong ones.
fn show_findings(findings: &[JudgedFinding], terminal: &Terminal) {
    for line in preflight::table(findings) {
        terminal.say(&line);
    }
    for sentence in preflight::sentences(findings, Verdict::Doubtful) {
        terminal.say(&sentence);
    }
    for sentence in preflight::sentences(findings, Verdict::Wrong) {
        terminal.point_out(&sentence);
    }
    terminal.say(&preflight::total(findings));
}
