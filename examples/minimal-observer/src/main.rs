//! The smallest observer: writes the largest speed of the bodies over time into `speeds.csv` in the
//! run's folder.
//!
//! In a manifest: `speeds = { program = "minimal-observer", role = "observer", lossless = true }`
//! in `[components]`.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use tremie_sdk::messages::Problem;
use tremie_sdk::messages::frame::BodySample;
use tremie_sdk::messages::start::{Description, Watches};
use tremie_sdk::{AsObserver, Moment, Observer, ObserverError, Setup, own_file};

struct Speeds {
    path: PathBuf,
    file: BufWriter<File>,
    rows: u64,
}

impl Observer for Speeds {
    const PROGRAM: &'static str = concat!("minimal-observer ", env!("CARGO_PKG_VERSION"));

    fn describe(_: &Setup) -> Result<Description, Vec<Problem>> {
        // Only what is asked for is set up and sent.
        let watches = Watches { slices: false, signals: false, log: false, ..Watches::default() };
        Ok(Description { watches, ..Description::default() })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let path = PathBuf::from(&setup.hello.output).join("speeds.csv");
        let mut file = BufWriter::new(own_file(&path)?);
        let head = writeln!(file, "window,time [s],largest speed [m/s]");
        head.map_err(|error| ObserverError::output(&path, &error))?;
        Ok(Self { path, file, rows: 0 })
    }

    fn bodies(&mut self, _: &str, at: Moment, bodies: &[BodySample]) -> Result<(), ObserverError> {
        let speed =
            |body: &BodySample| body.state.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let largest = bodies.iter().map(speed).fold(0.0, f64::max);
        self.rows += 1;
        let row = writeln!(self.file, "{},{},{largest}", at.stamp.window, at.time);
        row.map_err(|error| ObserverError::output(&self.path, &error))
    }

    fn close(&mut self, _: u64) -> Result<String, ObserverError> {
        self.file.flush().map_err(|error| ObserverError::output(&self.path, &error))?;
        Ok(format!("{} rows in {}", self.rows, self.path.display()))
    }
}

fn main() -> ExitCode {
    tremie_sdk::main::<AsObserver<Speeds>>()
}
