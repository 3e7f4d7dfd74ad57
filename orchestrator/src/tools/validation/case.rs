//! `case.toml`: source of a reference, runs to make, checks on their results.

use super::ValidationError;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file that makes a folder a case.
pub const FILE: &str = "case.toml";

/// A case.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Name of its folder.
    pub name: String,
    /// The folder.
    pub folder: PathBuf,
    /// Subject of the case, in a few words.
    pub title: String,
    /// Source of the reference.
    pub source: String,
    /// Notes for a reader: box, resolution, deviations from the source.
    pub about: String,
    /// The runs.
    pub runs: Vec<CaseRun>,
    /// Pictures of their results.
    pub pictures: Vec<Picture>,
}

/// A case as it is written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseDocument {
    title: String,
    source: String,
    #[serde(default)]
    about: String,
    runs: Vec<CaseRun>,
    #[serde(default)]
    pictures: Vec<Picture>,
}

/// A run of a case.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CaseRun {
    /// Name, unique in the case.
    pub name: String,
    /// Manifest, from the case's folder.
    #[serde(default = "manifest")]
    pub manifest: PathBuf,
    /// Values of the manifest to change, by key.
    #[serde(default)]
    pub set: BTreeMap<String, toml::Value>,
    /// Abscissa of the run in a picture over runs.
    pub x: Option<f64>,
    /// A form that ends within seconds; a run without one is left out of the short validation.
    pub short: Option<Short>,
    /// Checks on its results.
    #[serde(default)]
    pub checks: Vec<Check>,
}

fn manifest() -> PathBuf {
    "manifest.toml".into()
}

/// Further changes to the manifest for the short form of a run.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Short {
    /// Values of the manifest to change, by key.
    #[serde(default)]
    pub set: BTreeMap<String, toml::Value>,
}

/// Check of a result of a run against a reference.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Check {
    /// Name, in a few words.
    pub name: String,
    /// Kind of reference; a check with bounds must give it.
    pub kind: Option<CheckKind>,
    /// Reason why a failure of it stands: its cause, as far as it is known. Such a failure is
    /// shown, and does not fail the validation.
    pub stands: Option<String>,
    /// The number to take.
    pub value: Option<Measure>,
    /// Divisor of the number.
    pub over: Option<Measure>,
    /// The same number of a run whose cells are twice as large. The result is then carried on to
    /// cells of size zero, for errors of second order (Richardson's extrapolation).
    pub coarser: Option<Measure>,
    /// The reference for it.
    pub expected: Option<f64>,
    /// Or bounds for it.
    pub between: Option<[f64; 2]>,
    /// Or many numbers at once: a file with columns `signal`, `expected` and, for pictures, `x`.
    /// Their last values count.
    pub table: Option<PathBuf>,
    /// Factor on all signals of the table.
    #[serde(default = "one")]
    pub scale: f64,
    /// Largest deviation: relative to `expected`, absolute for a table.
    pub tolerance: Option<f64>,
    /// Largest deviation of a short run, if that is another.
    pub short_tolerance: Option<f64>,
    /// Bounds for a short run, if those are others.
    pub short_between: Option<[f64; 2]>,
    /// Unit, for the report.
    #[serde(default)]
    pub unit: String,
}

/// Kind of reference, and so the meaning of a passed check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CheckKind {
    /// Theory, experiment, or other people's computations: the physics is right within the
    /// tolerance.
    #[default]
    Reference,
    /// A direction or an order that a source describes: the physics answers as it should.
    Trend,
    /// An earlier result, within bounds of our own: it has not changed. This says nothing of being
    /// right.
    Record,
}

impl CheckKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Reference, Self::Trend, Self::Record];

    /// Its name, as cases write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Trend => "trend",
            Self::Record => "record",
        }
    }
}

fn one() -> f64 {
    1.0
}

/// A number from a table of signals.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// The signal, `component.name`.
    pub signal: String,
    /// Name of another run of the case, made before, whose signal is taken.
    pub run: Option<String>,
    /// A signal that is subtracted first.
    pub minus: Option<String>,
    /// Reduction of the signal to a number.
    pub take: Take,
    /// Time from which on it counts [s].
    #[serde(default)]
    pub from: f64,
    /// Time up to which it counts [s].
    #[serde(default = "for_ever")]
    pub until: f64,
    /// Event from which on it counts.
    pub once: Option<Threshold>,
    /// Factor.
    #[serde(default = "one")]
    pub scale: f64,
}

/// The first time at which a signal is more than something.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Threshold {
    /// The signal, `component.name`.
    pub signal: String,
    /// Bound that it exceeds, in the signal's unit.
    pub exceeds: f64,
}

fn for_ever() -> f64 {
    f64::INFINITY
}

/// Reduction of a signal over time to a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// The first value.
    First,
    /// The last value.
    Last,
    /// The mean over time.
    Mean,
    /// The greatest value.
    Max,
    /// The least value.
    Min,
    /// The greatest magnitude.
    MaxAbs,
    /// Greatest minus least value.
    PeakToPeak,
    /// Frequency of the crossings of its mean upwards [1/s].
    Frequency,
    /// Rate of growth: slope of the line of least squares [unit of the signal/s].
    Slope,
    /// Time of the first value that counts [s]; with `once`, the time of that event.
    TimeOfFirst,
    /// Time of the greatest value [s].
    TimeOfMax,
    /// Time of the least value [s].
    TimeOfMin,
}

/// A picture of a case's results.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Picture {
    /// Name of its file, without extension.
    pub file: String,
    /// Title.
    pub title: String,
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Curves and marks.
    pub draw: Draw,
    /// The horizontal axis is logarithmic.
    #[serde(default)]
    pub log_x: bool,
}

/// Content of a picture.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Draw {
    /// A check by table: reference as marks, results as lines, for all runs that have it.
    Table(String),
    /// Signals over time, for all runs.
    Signals(Vec<String>),
    /// A check's numbers over the runs' `x`, with the reference.
    Check(String),
}

impl Case {
    /// Reads the case in a folder.
    ///
    /// # Errors
    /// If there is none, or it is wrong.
    pub fn read(folder: &Path) -> Result<Self, ValidationError> {
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path).map_err(ValidationError::io(&path))?;
        let document: CaseDocument =
            toml::from_str(&text).map_err(|error| ValidationError::content(&path, error))?;
        let CaseDocument { title, source, about, runs, pictures } = document;
        let name = folder.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
        let case =
            Self { name, folder: folder.to_path_buf(), title, source, about, runs, pictures };
        match case.fault() {
            Some(fault) => Err(ValidationError::content(&path, fault)),
            None => Ok(case),
        }
    }

    /// A check, by the names of its run and its own.
    pub fn check(&self, run: &str, check: &str) -> Option<&Check> {
        let run = self.runs.iter().find(|other| other.name == run)?;
        run.checks.iter().find(|other| other.name == check)
    }

    /// First fault that the types do not rule out.
    fn fault(&self) -> Option<String> {
        let names: Vec<_> = self.runs.iter().map(|run| &run.name).collect();
        if let Some(k) = (1..names.len()).find(|k| names[..*k].contains(&names[*k])) {
            return Some(format!("two runs are called \"{}\"", names[k]));
        }
        self.runs.iter().enumerate().find_map(|(k, run)| {
            let fault = |check: &Check| check.fault(&run.name, &self.runs[..k]);
            run.checks.iter().find_map(fault)
        })
    }
}

impl Check {
    fn fault(&self, run: &str, before: &[CaseRun]) -> Option<String> {
        let of = format!("run \"{run}\", check \"{}\"", self.name);
        let references = [self.expected.is_some(), self.between.is_some(), self.table.is_some()];
        if references.iter().filter(|given| **given).count() != 1 {
            return Some(format!("{of}: needs one of expected, between, table"));
        }
        if self.value.is_some() == self.table.is_some() {
            return Some(format!("{of}: needs a value, unless it has a table"));
        }
        let measures = self.value.iter().chain(&self.over);
        for other in measures.filter_map(|measure| measure.run.as_ref()) {
            if !before.iter().any(|run| run.name == *other) {
                return Some(format!("{of}: no run before it is called \"{other}\""));
            }
        }
        if self.between.is_some() && self.kind.is_none() {
            return Some(format!("{of}: needs a kind: reference, trend or record"));
        }
        if self.between.is_none() && !self.tolerance.is_some_and(|t| t >= 0.0) {
            return Some(format!("{of}: needs a tolerance, 0 or more"));
        }
        None
    }

    /// Tolerance of a run.
    pub fn tolerance(&self, short: bool) -> f64 {
        self.short_tolerance.filter(|_| short).or(self.tolerance).unwrap_or(0.0)
    }

    /// Bounds of a run.
    pub fn bounds(&self, short: bool) -> Option<[f64; 2]> {
        self.short_between.filter(|_| short).or(self.between)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Case, ValidationError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(FILE), text).unwrap();
        Case::read(folder.path())
    }

    const GOOD: &str = r#"
        title = "A case"
        source = "Somebody, 1900"
        [[runs]]
        name = "only"
        [runs.short]
        set = { "run.until" = "1 s" }
        [[runs.checks]]
        name = "speed"
        value = { signal = "grains.max_speed", take = "max" }
        expected = 2.0
        tolerance = 0.01
        short_tolerance = 0.1
    "#;

    #[test]
    fn a_case_is_read() {
        let case = read(GOOD).unwrap();
        let check = &case.runs[0].checks[0];
        assert_eq!((check.tolerance(false), check.tolerance(true)), (0.01, 0.1));
        assert_eq!(check.value.as_ref().unwrap().until, f64::INFINITY);
    }

    #[test]
    fn a_wrong_case_is_refused_with_its_place() {
        for (from, to, says) in [
            ("expected = 2.0", "", "one of expected"),
            ("tolerance = 0.01", "", "needs a tolerance"),
            ("take = \"max\"", "take = \"most\"", "unknown variant"),
            ("name = \"speed\"", "name = \"speed\"\ncolour = 1", "unknown field"),
            (
                "take = \"max\"",
                "take = \"max\", run = \"only\"",
                "no run before it is called \"only\"",
            ),
        ] {
            let error = read(&GOOD.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }
}
