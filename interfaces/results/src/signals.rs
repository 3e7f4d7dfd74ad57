//! The table of signals of a run, finished or not.
//!
//! A run that was killed leaves a table whose last row is cut off anywhere, also in the middle of a
//! number that reads as another. A row therefore counts only with the end of its line.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// File of the table in a run's folder.
pub const SIGNALS: &str = "signals.csv";

/// Signals over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Simulated times [s].
    pub times: Vec<f64>,
    /// Values by `component.name`.
    pub columns: BTreeMap<String, Vec<f64>>,
    /// SI units by the same names.
    pub units: BTreeMap<String, String>,
    /// End of the whole rows, if the table was cut off.
    pub cut: Option<Cut>,
}

/// A table that was cut off.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// Path of the file.
    pub path: PathBuf,
    /// Rows that are whole.
    pub rows: usize,
    /// Simulated time of the last of them [s].
    pub until: Option<f64>,
}

impl std::fmt::Display for Cut {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { path, rows, until } = self;
        write!(f, "{} is cut off in its last row: {rows} whole rows are read", path.display())?;
        until.map_or(Ok(()), |until| write!(f, ", up to {until} s"))
    }
}

/// A table of signals cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {why}", path.display())]
pub struct UnreadableSignals {
    /// Path of the file.
    pub path: PathBuf,
    /// Reason, a sentence.
    pub why: String,
}

impl Signals {
    /// Reads `signals.csv`, to its last whole row: [`Signals::cut`] says if there is more.
    ///
    /// # Errors
    /// If it cannot be read, or has no whole line of names.
    pub fn read(path: &Path) -> Result<Self, UnreadableSignals> {
        let wrong = |why: String| UnreadableSignals { path: path.to_path_buf(), why };
        let bytes = std::fs::read(path).map_err(|error: io::Error| wrong(error.to_string()))?;
        let mut signals = Self::parse(&bytes).map_err(wrong)?;
        if let Some(cut) = &mut signals.cut {
            cut.path = path.to_path_buf();
        }
        Ok(signals)
    }

    /// Reads a table from its text.
    ///
    /// # Errors
    /// A sentence.
    pub fn parse(bytes: &[u8]) -> Result<Self, String> {
        if bytes.is_empty() {
            return Err("it is empty; its run ended before the first row".into());
        }
        // Everything after the last end of a line may be half a number, and is left out.
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        if whole == 0 {
            return Err("it is cut off in its first line, the names of the signals".into());
        }
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            // A row of another length is reported below, with its line.
            .flexible(true)
            .from_reader(&bytes[..whole]);
        let mut heads: Vec<(String, String)> = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut record = csv::ByteRecord::new();
        while reader.read_byte_record(&mut record).map_err(|error| error.to_string())? {
            let line = record.position().map_or(0, csv::Position::line);
            if heads.is_empty() {
                heads = names(&record)?;
                columns.resize(heads.len(), Vec::new());
                continue;
            }
            if record.len() != heads.len() {
                let (found, expected) = (record.len(), heads.len());
                return Err(format!(
                    "line {line} has {found} values, the first line {expected} names"
                ));
            }
            for ((field, column), (name, _)) in record.iter().zip(&mut columns).zip(&heads) {
                let text = String::from_utf8_lossy(field);
                let value = text.trim().parse().map_err(|_| {
                    format!("line {line}: \"{text}\" in the column {name} is no number")
                })?;
                column.push(value);
            }
        }
        let names = heads.iter().map(|(name, _)| name.clone());
        let mut columns: BTreeMap<String, Vec<f64>> = names.zip(columns).collect();
        // The number of the window is no signal.
        columns.remove("window");
        let times = columns.remove("time").unwrap_or_default();
        let cut = (whole < bytes.len()).then(|| Cut {
            path: PathBuf::new(),
            rows: times.len(),
            until: times.last().copied(),
        });
        Ok(Self { times, columns, units: heads.into_iter().collect(), cut })
    }

    /// The values of a signal.
    ///
    /// # Errors
    /// A sentence, if the run has no such signal.
    pub fn column(&self, name: &str) -> Result<&[f64], String> {
        self.columns.get(name).map(Vec::as_slice).ok_or_else(|| {
            let known: Vec<&str> = self.columns.keys().map(String::as_str).collect();
            match tremie_messages::nearest(name, &known) {
                Some(near) => format!("there is no signal \"{name}\"; did you mean \"{near}\"?"),
                None => format!("there is no signal \"{name}\""),
            }
        })
    }
}

/// The names and units of the first line.
fn names(record: &csv::ByteRecord) -> Result<Vec<(String, String)>, String> {
    let heads: Vec<_> =
        record.iter().map(|head| name_and_unit(&String::from_utf8_lossy(head))).collect();
    match heads.iter().take(2).map(|(name, _)| name.as_str()).collect::<Vec<_>>()[..] {
        ["window", "time"] => Ok(heads),
        _ => {
            Err("it is no table of signals: its first line does not begin with window and time"
                .into())
        }
    }
}

/// `fluid.mass [kg]` as its name and its unit.
pub(crate) fn name_and_unit(head: &str) -> (String, String) {
    let (name, unit) = head.split_once(" [").unwrap_or((head, "1]"));
    (name.into(), unit.trim_end_matches(']').into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TABLE: &str = "window,time [s],a.x [m]\n0,0,1.5\n1,0.25,NaN\n2,0.5,-3.25e-7\n";

    fn why(text: &[u8]) -> String {
        Signals::parse(text).unwrap_err()
    }

    #[test]
    fn a_table_is_read_to_its_last_whole_row_wherever_it_is_cut() {
        let whole = Signals::parse(TABLE.as_bytes()).unwrap();
        assert_eq!((whole.times.as_slice(), whole.cut), (&[0.0, 0.25, 0.5][..], None));
        let names = TABLE.find('\n').unwrap() + 1;
        for end in names..TABLE.len() {
            let text = &TABLE[..end];
            let rows = text.matches('\n').count() - 1;
            let signals = Signals::parse(text.as_bytes()).unwrap();
            assert_eq!(signals.times, whole.times[..rows], "{text}");
            let cut = signals.cut.map(|cut| (cut.rows, cut.until));
            let expected = (rows, signals.times.last().copied());
            assert_eq!(cut, (!text.ends_with('\n')).then_some(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_table_is_refused_in_a_sentence() {
        for (text, part) in [
            ("", "it is empty"),
            ("window,time [s],flu", "cut off in its first line"),
            (
                "window,time [s],a.x [m]\n0,0,1\n1,0\n2,0,1\n",
                "line 3 has 2 values, the first line 3",
            ),
            ("window,time [s],a.x [m]\n0,0,1\n1,0,2,3\n", "line 3 has 4 values"),
            (
                "window,time [s],a.x [m]\n0,0,1\n1,zero,2\n",
                "line 3: \"zero\" in the column time is no",
            ),
            ("\0\0\0\0\0\n", "no table of signals"),
            ("a,b\n1,2\n", "no table of signals"),
        ] {
            assert!(why(text.as_bytes()).contains(part), "{text:?}: {}", why(text.as_bytes()));
        }
        // A machine that lost its power leaves zeros at the end of a file.
        let torn = [TABLE.as_bytes(), &[0; 300]].concat();
        assert_eq!(Signals::parse(&torn).unwrap().cut.unwrap().rows, 3);
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_table_or_a_sentence(
            bytes in proptest::collection::vec(any::<u8>(), 0..200), at in 0..TABLE.len(),
        ) {
            let _ = Signals::parse(&bytes);
            let mut table = TABLE.as_bytes().to_vec();
            table.splice(at..at, bytes);
            if let Ok(signals) = Signals::parse(&table) {
                prop_assert!(signals.columns.values().all(|column| column.len() == signals.times.len()));
            }
        }
    }
}
