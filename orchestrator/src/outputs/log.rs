//! The run's log: one JSON document a line.

use super::folder::OutputError;
use serde::Serialize;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Severity of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LogLevel {
    /// Something that a reader may want to know.
    Info,
    /// Something that may spoil a result.
    Warning,
    /// Something that ended the run.
    Error,
}

/// The run's log file.
#[derive(Debug)]
pub struct RunLog {
    file: BufWriter<File>,
    path: PathBuf,
}

#[derive(Serialize)]
struct LogEntry<'a> {
    level: LogLevel,
    from: &'a str,
    window: u64,
    time: f64,
    message: &'a str,
}

impl RunLog {
    /// Opens the log at `path`.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(OutputError::at(path))?;
        Ok(Self { file: BufWriter::new(file), path: path.to_path_buf() })
    }

    /// Opens the log of a run that goes on: lines are added to it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn reopen(path: &Path) -> Result<Self, OutputError> {
        let file = File::options().append(true).create(true).open(path);
        let file = file.map_err(OutputError::at(path))?;
        Ok(Self { file: BufWriter::new(file), path: path.to_path_buf() })
    }

    /// Writes a line: its source, its window and simulated time [s], its text.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn write(
        &mut self,
        level: LogLevel,
        from: &str,
        window: u64,
        time: f64,
        message: &str,
    ) -> Result<(), OutputError> {
        let entry = LogEntry { level, from, window, time, message };
        serde_json::to_writer(&mut self.file, &entry)
            .map_err(std::io::Error::from)
            .and_then(|()| self.file.write_all(b"\n"))
            // At once: the log of a killed run is whole up to its last line.
            .and_then(|()| self.file.flush())
            .map_err(OutputError::at(&self.path))
    }
}
