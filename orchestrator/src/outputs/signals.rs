//! The table of signals, and their extremes.

use super::folder::OutputError;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use tremie_messages::start::{Clock, Signal};
use tremie_sdk::check_length;
use tremie_state::{StateError, StateExchange};

/// Least, greatest and last value of a signal, with the times of the extremes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// SI unit.
    pub unit: String,
    /// Meaning of the signal; empty where its component does not say.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub meaning: String,
    /// Least value.
    pub min: f64,
    /// Simulated time of its first occurrence [s].
    pub min_at: f64,
    /// Greatest value.
    pub max: f64,
    /// Simulated time of its first occurrence [s].
    pub max_at: f64,
    /// Value at the end.
    pub last: f64,
    /// The signal is measured in some windows only.
    #[serde(skip)]
    sampled: bool,
}

/// Signals of one window: those of all components, one component after the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalRow {
    /// The window.
    pub window: u64,
    /// Values of all signals.
    pub values: Vec<f64>,
}

/// Bytes of rows that csv collects; less than what the writer behind it collects.
const OF_ROWS: usize = 1 << 10;
/// Bytes that the writer behind it collects.
const OF_FILE: usize = 8 << 10;

/// Writes rows into a file. After a failure csv would write all that it had collected once more; the writer
/// between knows how much of it the disk took. So a checkpoint that finds no room spoils no row.
fn writer(file: File) -> csv::Writer<BufWriter<File>> {
    let file = BufWriter::with_capacity(OF_FILE, file);
    csv::WriterBuilder::new().buffer_capacity(OF_ROWS).from_writer(file)
}

/// `signals.csv`: window, time and all signals, a row every so many windows and the last one.
#[derive(Debug)]
pub struct SignalTable {
    table: csv::Writer<BufWriter<File>>,
    path: PathBuf,
    clock: Clock,
    every: u64,
    names: Vec<String>,
    statistics: Vec<Statistics>,
    /// The newest row, if it was not due.
    held: Option<SignalRow>,
}

impl SignalTable {
    /// Opens the table at `path` for signals with these full names (`component.signal`).
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create(
        path: &Path,
        clock: Clock,
        every: u64,
        signals: &[(String, Signal)],
    ) -> Result<Self, OutputError> {
        // New: on a file system without locks this keeps one run out of the other's table.
        let file = File::create_new(path).map_err(OutputError::at(path))?;
        let mut table = writer(file);
        let head = |(name, signal): &(String, Signal)| format!("{name} [{}]", signal.unit);
        let fixed = ["window".to_string(), "time [s]".to_string()];
        let heads = fixed.into_iter().chain(signals.iter().map(head));
        // Whatever becomes of the run, its columns are known.
        let begun = table.write_record(heads).map_err(io::Error::from);
        begun.and_then(|()| table.flush()).map_err(OutputError::at(path))?;
        let statistics = signals.iter().map(|(_, signal)| Statistics::none(signal)).collect();
        let names = signals.iter().map(|(name, _)| name.clone()).collect();
        let path = path.to_path_buf();
        Ok(Self { table, path, clock, every: every.max(1), names, statistics, held: None })
    }

    /// Opens the table of a run that goes on; [`SignalTable::exchange`] then puts it back to where the
    /// checkpoint was made.
    ///
    /// # Errors
    /// If the file is not there, or cannot be written.
    pub fn reopen(
        path: &Path,
        clock: Clock,
        every: u64,
        signals: &[(String, Signal)],
    ) -> Result<Self, OutputError> {
        let file = OpenOptions::new().read(true).write(true).open(path);
        let table = writer(file.map_err(OutputError::at(path))?);
        let statistics = signals.iter().map(|(_, signal)| Statistics::none(signal)).collect();
        let names = signals.iter().map(|(name, _)| name.clone()).collect();
        let path = path.to_path_buf();
        Ok(Self { table, path, clock, every: every.max(1), names, statistics, held: None })
    }

    /// Keeps what is in the table, once the disk has it, or puts it back: rows that came later are gone
    /// then.
    ///
    /// # Errors
    /// If the disk refuses, or the table is shorter than it was.
    pub fn exchange(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let failed = |error| StateError::Io { path: self.path.clone(), error };
        let mut length = 0;
        if !state.restores() {
            self.table.flush().map_err(failed)?;
            self.table.get_ref().get_ref().sync_data().map_err(failed)?;
            length = self.table.get_ref().get_ref().metadata().map_err(failed)?.len();
        }
        state.value("length", &mut length)?;
        state.value("held", &mut self.held)?;
        for (name, statistics) in self.names.iter().zip(&mut self.statistics) {
            let Statistics { min, min_at, max, max_at, last, .. } = statistics;
            let mut values = [*min, *min_at, *max, *max_at, *last];
            state.array(&format!("statistics.{name}"), &mut values)?;
            [*min, *min_at, *max, *max_at, *last] = values;
        }
        if state.restores() {
            let mut file = self.table.get_ref().get_ref();
            let found = file.metadata().map_err(failed)?.len();
            check_length(&self.path, found, length)?;
            file.set_len(length).map_err(failed)?;
            file.seek(SeekFrom::End(0)).map_err(failed)?;
        }
        Ok(())
    }

    /// Takes the row of a window; rows come in order.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn take(&mut self, row: SignalRow) -> Result<(), OutputError> {
        let time = self.time(&row);
        for (statistics, value) in self.statistics.iter_mut().zip(&row.values) {
            statistics.take(time, *value);
        }
        // A row that is not due is held: the last one of a run is written whether due or not.
        if row.window.is_multiple_of(self.every) {
            self.held = None;
            self.write(&row)
        } else {
            self.held = Some(row);
            Ok(())
        }
    }

    /// Writes the last row even if it is not due, and everything to disk.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn close(&mut self) -> Result<(), OutputError> {
        if let Some(row) = self.held.take() {
            self.write(&row)?;
        }
        self.table.flush().map_err(OutputError::at(&self.path))
    }

    /// Every signal's extremes and last value, also from rows that a full disk did not take.
    pub fn into_statistics(self) -> Vec<(String, Statistics)> {
        self.names.into_iter().zip(self.statistics).collect()
    }

    /// The newest value of the signal of this full name; `None` before there is one.
    pub fn newest(&self, name: &str) -> Option<f64> {
        let at = self.names.iter().position(|own| own == name)?;
        Some(self.statistics[at].last).filter(|last| !last.is_nan())
    }

    fn time(&self, row: &SignalRow) -> f64 {
        self.clock.seconds(row.window * self.clock.ticks_per_window)
    }

    fn write(&mut self, row: &SignalRow) -> Result<(), OutputError> {
        let fixed = [row.window.to_string(), self.time(row).to_string()];
        // Rust prints the shortest decimal that reads back as the same bits.
        let values = row.values.iter().map(f64::to_string);
        let written = self.table.write_record(fixed.into_iter().chain(values));
        written.map_err(|error| OutputError::at(&self.path)(error.into()))
    }
}

impl Statistics {
    fn none(signal: &Signal) -> Self {
        let Signal { unit, meaning, sampled, .. } = signal.clone();
        let none = f64::NAN;
        Self {
            unit,
            meaning,
            min: none,
            min_at: none,
            max: none,
            max_at: none,
            last: none,
            sampled,
        }
    }

    /// Takes a value, if it was measured.
    fn take(&mut self, time: f64, value: f64) {
        if self.sampled && value.is_nan() {
            return;
        }
        if self.min.is_nan() || value < self.min {
            (self.min, self.min_at) = (value, time);
        }
        if self.max.is_nan() || value > self.max {
            (self.max, self.max_at) = (value, time);
        }
        self.last = value;
    }
}
