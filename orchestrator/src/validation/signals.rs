//! The table of signals of a finished run.

use super::ValidationError;
use std::collections::BTreeMap;
use std::path::Path;

/// Signals over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Simulated times [s].
    pub times: Vec<f64>,
    /// Values by `component.name`.
    pub columns: BTreeMap<String, Vec<f64>>,
}

impl Signals {
    /// Reads `signals.csv`.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(path: &Path) -> Result<Self, ValidationError> {
        let wrong = |error: csv::Error| ValidationError::content(path, error);
        let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
        let without_unit = |name: &str| name.split(" [").next().unwrap_or(name).to_string();
        let names: Vec<String> =
            reader.headers().map_err(wrong)?.iter().map(without_unit).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for row in reader.deserialize() {
            let row: Vec<f64> = row.map_err(wrong)?;
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        let mut columns: BTreeMap<String, Vec<f64>> = names.into_iter().zip(columns).collect();
        columns.remove("window");
        let times = columns.remove("time").unwrap_or_default();
        Ok(Self { times, columns })
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
