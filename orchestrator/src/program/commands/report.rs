//! `tremie report OUT...`: draws the curves of finished runs.

use super::WRONG_INPUT;
use crate::program::cli::ReportArgs;
use crate::terminal::standard::{answer, complain};
use crate::tools::report::{self, ReportError};
use std::path::PathBuf;
use std::process::ExitCode;

/// Most signals listed that never change.
const LISTED: usize = 12;

/// `tremie report`: one picture, and a line with its path.
pub fn report(arguments: &ReportArgs) -> ExitCode {
    match make(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain(format_args!("error: {error}"));
            match error {
                ReportError::Unknown { .. }
                | ReportError::Signals(_)
                | ReportError::Profile(_)
                | ReportError::NoSpectrum { .. } => WRONG_INPUT.into(),
                _ => ExitCode::FAILURE,
            }
        }
    }
}

fn make(arguments: &ReportArgs) -> Result<(), ReportError> {
    let mut report = report::report(&arguments.outs, &arguments.signals)?;
    if arguments.spectrum {
        let from = arguments.from.map_or(f64::NEG_INFINITY, |time| time.0);
        let until = arguments.until.map_or(f64::INFINITY, |time| time.0);
        report = report::spectra(report, [from, until])?;
    }
    for cut in &report.cuts {
        complain(format_args!("warning: {cut}"));
    }
    let path = arguments.to.clone().unwrap_or_else(|| arguments.outs[0].join("report.svg"));
    let name = |out: &PathBuf| out.file_name().map(|name| name.to_string_lossy().into_owned());
    let names: Vec<String> = arguments.outs.iter().filter_map(name).collect();
    report::draw(&report, &names.join(", "), &path)?;
    let curves: usize = report.panels.iter().map(|panel| panel.curves.len()).sum();
    let panels = report.panels.len();
    let of_profiles = match report.profiles.len() {
        0 => String::new(),
        panels => format!(", and {panels} panels of profiles"),
    };
    let path = path.display();
    answer(format_args!("{path}: {curves} curves in {panels} panels{of_profiles}"));
    for line in report.notes.iter() {
        answer(format_args!("  {line}"));
    }
    for (name, value, unit) in report.constant.iter().take(LISTED) {
        let unit = if unit == "1" { "" } else { unit };
        answer(format_args!("  {name} is {} throughout", format!("{value} {unit}").trim_end()));
    }
    if let Some(more) = report.constant.len().checked_sub(LISTED + 1) {
        answer(format_args!("  and {} more that never change", more + 1));
    }
    Ok(())
}
