//! The observer.

use crate::arrays;
use crate::columns::{ProfileTable, write_head, write_rows};
use crate::parameters::Parameters;
use std::error::Error;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::GrainProfile;
use tremie_messages::start::{Description, Watches};
use tremie_messages::{INTERFACE_VERSION, Problem};
use tremie_sdk::{AsObserver, ControlPipe, Moment, Observer, ObserverError, Setup, own_file};

/// Writes profiles as CSV and NumPy files.
pub struct ProfileWriter {
    folder: PathBuf,
    parameters: Parameters,
    profiles: Vec<ProfileFiles>,
}

/// The files of a profile.
struct ProfileFiles {
    profile: GrainProfile,
    path: PathBuf,
    rows: csv::Writer<File>,
    tables: Vec<ProfileTable>,
    /// Length of the file of rows after each table [bytes], and before the first.
    lengths: Vec<u64>,
}

fn failed(path: &Path, error: &(dyn Error + 'static)) -> ObserverError {
    ObserverError::output(path, error)
}

impl ProfileFiles {
    fn open(folder: &Path, profile: &GrainProfile) -> Result<Self, ObserverError> {
        let path = folder.join(format!("{}.csv", profile.name));
        let mut rows = csv::Writer::from_writer(own_file(&path)?);
        let begun = write_head(&mut rows, profile);
        begun.map_err(|error| failed(&path, &error))?;
        let mut files =
            Self { profile: profile.clone(), path, rows, tables: Vec::new(), lengths: Vec::new() };
        files.note_length()?;
        Ok(files)
    }

    fn note_length(&mut self) -> Result<(), ObserverError> {
        let metadata = self.rows.get_ref().metadata();
        self.lengths.push(metadata.map_err(|error| failed(&self.path, &error))?.len());
        Ok(())
    }

    fn take(&mut self, table: ProfileTable) -> Result<(), ObserverError> {
        let written = write_rows(&mut self.rows, &self.profile, &table);
        written.map_err(|error| failed(&self.path, &error))?;
        self.tables.push(table);
        self.note_length()
    }

    /// Takes out tables that end later than a window, and writes the arrays.
    fn close(&mut self, last_window: u64) -> Result<(), ObserverError> {
        let kept = self.tables.partition_point(|table| table.window <= last_window);
        if kept < self.tables.len() {
            self.tables.truncate(kept);
            let cut: io::Result<()> = self.rows.get_ref().set_len(self.lengths[kept]);
            cut.map_err(|error| failed(&self.path, &error))?;
        }
        let path = self.path.with_extension("npz");
        arrays::write(&path, &self.profile, &self.tables).map_err(|error| failed(&path, &error))
    }
}

impl Observer for ProfileWriter {
    const PROGRAM: &'static str = concat!("profiles ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        setup.parameters::<Parameters>()?;
        Ok(Description {
            interface: INTERFACE_VERSION,
            program: Self::PROGRAM.into(),
            watches: Watches {
                bodies: false,
                surfaces: false,
                slices: false,
                profiles: true,
                signals: false,
                log: false,
                volumes: None,
            },
            ..Description::default()
        })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let parameters: Parameters = setup.parameters()?;
        let folder = parameters.path(&setup.hello.output);
        std::fs::create_dir_all(&folder).map_err(|error| failed(&folder, &error))?;
        let profiles = &setup.hello.scene.profiles;
        let profiles = profiles.iter().map(|profile| ProfileFiles::open(&folder, profile));
        Ok(Self { profiles: profiles.collect::<Result<_, _>>()?, parameters, folder })
    }

    fn profile(
        &mut self,
        _from: &str,
        name: &str,
        at: Moment,
        header: &ProfileHeader,
        bins: &[ProfileBin],
    ) -> Result<(), ObserverError> {
        match self.profiles.iter_mut().find(|files| files.profile.name == name) {
            Some(files) if files.profile.bins() == bins.len() => {
                files.take(ProfileTable::new(at.stamp.window, header, bins))
            }
            _ => Err(ObserverError::Other(format!(
                "{}: a table of {} bins came for the profile \"{name}\", which the scene does not have",
                self.folder.display(),
                bins.len()
            ))),
        }
    }

    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError> {
        let mut counts = Vec::new();
        for files in &mut self.profiles {
            files.close(last_common_window)?;
            counts.push(format!("{} of {}", files.tables.len(), files.profile.name));
        }
        Ok(format!("{}/: tables {}", self.parameters.folder.display(), counts.join(", ")))
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsObserver<ProfileWriter>>(line)
}
