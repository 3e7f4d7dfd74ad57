//! `tremie report OUT`: the curves of finished runs on one sheet.
//!
//! Signals of one kind share a panel ([`panels`]): the pressures of all probes, the three
//! components of a momentum. Several runs are drawn into the same panels. Signals that never change
//! are listed beneath instead.

pub mod panels;
pub mod scale;
pub mod sheet;

use panels::Panel;
use std::path::{Path, PathBuf};
use tremie_results::{Cut, NoSignals, Signals, run_name, signals_of};

/// A report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A run left no signals.
    #[error("{0}")]
    Signals(#[from] NoSignals),
    /// A signal that was asked for is not there.
    #[error("{}: {message}", out.display())]
    Unknown {
        /// Folder of the run.
        out: PathBuf,
        /// A sentence, with the nearest signal there is.
        message: String,
    },
    /// Nothing in these runs changes.
    #[error("no signal of {0} changes over time: there is nothing to draw")]
    Nothing(String),
    /// The picture could not be written.
    #[error("{}: cannot draw: {message}", path.display())]
    Picture {
        /// File of the picture.
        path: PathBuf,
        /// The error of the drawing.
        message: String,
    },
}

/// A finished run.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name in legends: the name of its folder.
    pub name: String,
    /// Its signals.
    pub signals: Signals,
}

/// Content of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Tables that were cut off.
    pub cuts: Vec<Cut>,
    /// Panels, in order.
    pub panels: Vec<Panel>,
    /// Signals that never change, and their values in the first run that has them.
    pub constant: Vec<(String, f64, String)>,
}

/// Reads the runs in the folders `outs` and sorts their signals. With `wanted`, only signals that
/// begin with one of these names.
///
/// # Errors
/// Runs without signals, signals that none of them has.
pub fn report(outs: &[PathBuf], wanted: &[String]) -> Result<Report, ReportError> {
    let mut runs = Vec::new();
    for out in outs {
        let signals = signals_of(out)?;
        for name in wanted {
            if !signals.columns.keys().any(|key| panels::begins(key, name)) {
                let message = signals.column(name).err().unwrap_or_default();
                return Err(ReportError::Unknown { out: out.clone(), message });
            }
        }
        runs.push(Run { name: run_name(out), signals });
    }
    let mut report = panels::sort(&runs, wanted);
    report.cuts.extend(runs.iter().filter_map(|run| run.signals.cut.clone()));
    if report.panels.is_empty() {
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        return Err(ReportError::Nothing(names.join(", ")));
    }
    Ok(report)
}

/// Draws a report as SVG.
///
/// # Errors
/// If the picture cannot be written.
pub fn draw(report: &Report, title: &str, path: &Path) -> Result<(), ReportError> {
    sheet::draw(report, title, path)
        .map_err(|message| ReportError::Picture { path: path.to_path_buf(), message })
}
