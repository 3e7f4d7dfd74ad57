//! `tremie report OUT...`: draws the curves of finished runs, and says where they end.

use super::WRONG_INPUT;
use crate::program::cli::ReportArgs;
use crate::terminal::standard::{answer, complain};
use crate::tools::report::{self, Report, ReportError, levels};
use std::path::Path;
use std::process::ExitCode;

/// Most signals listed that never change.
const LISTED: usize = 12;
/// Most signals whose levels are listed.
const LEVELS: usize = 60;

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
    report::draw(&report, &report.runs.join(", "), &path)?;
    let curves: usize = report.panels.iter().map(|panel| panel.curves.len()).sum();
    let panels = report.panels.len();
    let of_profiles = match report.profiles.len() {
        0 => String::new(),
        panels => format!(", and {panels} panels of profiles"),
    };
    let drawn = path.display();
    answer(format_args!("{drawn}: {curves} curves in {panels} panels{of_profiles}"));
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
    if !report.has_spectra {
        // No name that a run or a user may have given to a table of their own.
        let beside = match &arguments.to {
            None => path.with_extension("csv"),
            Some(picture) => picture.with_extension("levels.csv"),
        };
        tell_levels(&report, &beside)?;
    }
    Ok(())
}

/// Writes where the signals end into a file, and says it where they are few.
fn tell_levels(report: &Report, path: &Path) -> Result<(), ReportError> {
    report::write_levels(report, path)?;
    let (count, file) = (report.levels.len(), path.display());
    answer(format_args!(
        "{file}: where {count} signals end, means over the last tenth of the time"
    ));
    match count {
        0..=LEVELS => {
            for line in levels::lines(&report.levels, &report.runs) {
                answer(format_args!("  {line}"));
            }
        }
        _ => answer("  too many to list; --signal NAME lists some"),
    }
    Ok(())
}
