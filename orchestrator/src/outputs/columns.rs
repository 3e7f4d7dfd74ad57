//! The table of signals of a finished run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Signals over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Simulated times [s].
    pub times: Vec<f64>,
    /// Values by `component.name`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// SI units by the same names.
    pub units: BTreeMap<String, String>,
}

/// A table of signals cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {error}", path.display())]
pub struct UnreadableSignals {
    /// Which file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub error: csv::Error,
}

impl Signals {
    /// Reads `signals.csv`.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(path: &Path) -> Result<Self, UnreadableSignals> {
        Self::parse(path).map_err(|error| UnreadableSignals { path: path.to_path_buf(), error })
    }

    fn parse(path: &Path) -> Result<Self, csv::Error> {
        let mut reader = csv::Reader::from_path(path)?;
        let heads: Vec<(String, String)> = reader.headers()?.iter().map(name_and_unit).collect();
        let mut columns = vec![Vec::new(); heads.len()];
        for row in reader.deserialize() {
            let row: Vec<f64> = row?;
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        let names = heads.iter().map(|(name, _)| name.clone());
        let mut columns: BTreeMap<String, Vec<f64>> = names.zip(columns).collect();
        columns.remove("window");
        let times = columns.remove("time").unwrap_or_default();
        Ok(Self { times, columns, units: heads.into_iter().collect() })
    }

    /// The values of a signal.
    ///
    /// # Errors
    /// A sentence, if the run has no such signal.
    pub fn column(&self, name: &str) -> Result<&[f64], String> {
        self.columns.get(name).map(Vec::as_slice).ok_or_else(|| {
            let known: Vec<&str> = self.columns.keys().map(String::as_str).collect();
            match tremie_sdk::parameters::nearest(name, &known) {
                Some(near) => format!("there is no signal \"{name}\"; did you mean \"{near}\"?"),
                None => format!("there is no signal \"{name}\""),
            }
        })
    }
}

/// `fluid.mass [kg]` as its name and its unit.
fn name_and_unit(head: &str) -> (String, String) {
    let (name, unit) = head.split_once(" [").unwrap_or((head, "1]"));
    (name.into(), unit.trim_end_matches(']').into())
}
