//! `tremie report OUT`: the curves of finished runs on one sheet.
//!
//! Signals of one kind share a panel ([`panels`]): the pressures of all probes, the three
//! components of a momentum. Several runs are drawn into the same panels. Signals that never change
//! are listed beneath instead. Profiles of grains have panels of their own ([`profiles`]), which
//! come first. With `--spectrum` the panels have spectra instead ([`spectrum`]). The
//! levels at the runs' ends stand beside the picture, as numbers ([`levels`]).

pub mod levels;
pub mod panels;
pub mod profiles;
pub mod scale;
pub mod sheet;
pub mod spectrum;

use levels::LevelRow;
use panels::Panel;
use spectrum::NoSpectrum;
use std::path::{Path, PathBuf};
use tremie_results::{
    Cut, NoSignals, ProfileTables, SheetPanel, Signals, UnreadableProfile, profiles_of, run_name,
    signals_of,
};

/// A report could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A run left no signals.
    #[error("{0}")]
    Signals(#[from] NoSignals),
    /// A table of a profile cannot be read.
    #[error("{0}")]
    Profile(#[from] UnreadableProfile),
    /// A signal that was asked for is not there.
    #[error("{}: {message}", out.display())]
    Unknown {
        /// Folder of the run.
        out: PathBuf,
        /// A sentence, with the nearest signal there is.
        message: String,
    },
    /// A signal has no spectrum.
    #[error(
        "no spectrum of {name}: {why}; choose a time by --from and --until, or other signals by --signal"
    )]
    NoSpectrum {
        /// The panel's curve.
        name: String,
        /// The reason.
        why: NoSpectrum,
    },
    /// Nothing in these runs changes.
    #[error("no signal of {0} changes over time: there is nothing to draw")]
    Nothing(String),
    /// The numbers could not be written.
    #[error("{}: cannot write: {message}", path.display())]
    Numbers {
        /// File of the numbers.
        path: PathBuf,
        /// The system's words.
        message: String,
    },
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
    /// Its profiles of grains.
    pub profiles: Vec<ProfileTables>,
}

/// Content of a report.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Tables that were cut off.
    pub cuts: Vec<Cut>,
    /// Panels of profiles, before the others.
    pub profiles: Vec<SheetPanel>,
    /// Panels, in order.
    pub panels: Vec<Panel>,
    /// True if these have spectra.
    pub has_spectra: bool,
    /// A line on each curve of spectra.
    pub notes: Vec<String>,
    /// Signals that never change, and their values in the first run that has them.
    pub constant: Vec<(String, f64, String)>,
    /// Names of the runs.
    pub runs: Vec<String>,
    /// Where the signals stand at the ends of these runs.
    pub levels: Vec<LevelRow>,
}

/// Reads the runs in the folders `outs` and sorts their signals. With `wanted`, only signals that
/// begin with one of these names, and no profiles.
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
        let profiles = if wanted.is_empty() { profiles_of(out)? } else { Vec::new() };
        runs.push(Run { name: run_name(out), signals, profiles });
    }
    let mut report = panels::sort(&runs, wanted);
    report.profiles = of_profiles(&runs);
    report.levels = levels::levels(&runs, wanted);
    report.runs = runs.iter().map(|run| run.name.clone()).collect();
    report.cuts.extend(runs.iter().filter_map(|run| run.signals.cut.clone()));
    if report.panels.is_empty() && report.profiles.is_empty() {
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        return Err(ReportError::Nothing(names.join(", ")));
    }
    Ok(report)
}

/// Writes the numbers of a report into a file for a spreadsheet.
///
/// # Errors
/// If the file cannot be written.
pub fn write_levels(report: &Report, path: &Path) -> Result<(), ReportError> {
    let wrong = |message: String| ReportError::Numbers { path: path.into(), message };
    let table = levels::table(&report.levels, &report.runs);
    let table = table.map_err(|error| wrong(error.to_string()))?;
    std::fs::write(path, table).map_err(|error| wrong(error.to_string()))
}

/// The spectra of a report's signals, from one time to another, without its profiles.
///
/// # Errors
/// A signal that has no spectrum.
pub fn spectra(report: Report, interval: [f64; 2]) -> Result<Report, ReportError> {
    let spectra = spectrum::spectra(&report.panels, interval);
    let (panels, notes) = spectra.map_err(|(name, why)| ReportError::NoSpectrum { name, why })?;
    Ok(Report { panels, notes, has_spectra: true, profiles: Vec::new(), ..report })
}

/// Panels of the profiles of all runs; those of one name and as many axes share panels.
fn of_profiles(runs: &[Run]) -> Vec<SheetPanel> {
    let all = runs.iter().flat_map(|run| &run.profiles);
    let mut kinds: Vec<(&str, usize)> =
        all.map(|tables| (tables.name.as_str(), tables.axes.len())).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let name = |run: &'_ Run| if runs.len() > 1 { run.name.clone() } else { String::new() };
    let of_kind = |kind: (&str, usize)| {
        let is_it = |tables: &&ProfileTables| (tables.name.as_str(), tables.axes.len()) == kind;
        let with =
            runs.iter().filter_map(|run| Some((name(run), run.profiles.iter().find(is_it)?)));
        let with: Vec<_> = with.collect();
        let of_runs: Vec<_> =
            with.iter().map(|(run, tables)| profiles::RunProfile { run, tables }).collect();
        profiles::panels(&of_runs)
    };
    kinds.into_iter().flat_map(of_kind).collect()
}

/// Draws a report as SVG.
///
/// # Errors
/// If the picture cannot be written.
pub fn draw(report: &Report, title: &str, path: &Path) -> Result<(), ReportError> {
    sheet::draw(report, title, path)
        .map_err(|message| ReportError::Picture { path: path.to_path_buf(), message })
}
