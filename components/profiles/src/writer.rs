//! The observer.

use crate::arrays;
use crate::columns::{self, ProfileTable};
use crate::parameters::Parameters;
use std::error::Error;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::GrainProfile;
use tremie_messages::start::{Description, Watches};
use tremie_messages::{INTERFACE_VERSION, Problem, bytes_of, values_of};
use tremie_sdk::{
    AsObserver, ControlPipe, Moment, Observer, ObserverError, Setup, check_length, kept_file,
    own_file, sync,
};
use tremie_state::{StateError, StateExchange};

/// Version of the states: another one, too, whenever [`ProfileBin`] has other fields.
const STATE_VERSION: u32 = 1;

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
    file: File,
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
        let file = own_file(&path)?;
        let profile = profile.clone();
        let head = columns::head(&profile);
        let mut files = Self { profile, path, file, tables: Vec::new(), lengths: Vec::new() };
        files.add(head)?;
        Ok(files)
    }

    /// The files of the run before, before its state is put back.
    fn reopen(folder: &Path, profile: &GrainProfile) -> Result<Self, ObserverError> {
        let path = folder.join(format!("{}.csv", profile.name));
        let file = kept_file(&path, 0)?;
        let profile = profile.clone();
        Ok(Self { profile, path, file, tables: Vec::new(), lengths: Vec::new() })
    }

    /// The arrays are written from the tables when the run ends: these are kept, too.
    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let path = self.path.clone();
        state.relies_on(move || sync(&path));
        let head = |table: &ProfileTable| (table.window, table.times, table.samples);
        let mut heads: Vec<_> = self.tables.iter().map(head).collect();
        let mut bins: Vec<u8> =
            self.tables.iter().flat_map(|table| bytes_of(&table.bins)).copied().collect();
        state.value("tables", &mut heads)?;
        state.list("bins", &mut bins)?;
        state.list("lengths", &mut self.lengths)?;
        if !state.restores() {
            return Ok(());
        }
        let bins = values_of::<ProfileBin>(&bins).unwrap_or_default();
        let size = self.profile.bins();
        let Some(&length) = self
            .lengths
            .last()
            .filter(|_| self.lengths.len() == heads.len() + 1 && bins.len() == heads.len() * size)
        else {
            let (name, found) = (&self.profile.name, bins.len());
            return state.unfit(format!(
                "the state has {found} bins of {} tables of the profile \"{name}\", expected {size} of each",
                heads.len()
            ));
        };
        let table = |(k, (window, times, samples)): (usize, (u64, [f64; 2], u64))| {
            let bins = bins[k * size..(k + 1) * size].to_vec();
            ProfileTable { window, times, samples, bins }
        };
        self.tables = heads.into_iter().enumerate().map(table).collect();
        self.go_on(length)
    }

    /// Goes on after the first `length` bytes of the rows.
    fn go_on(&mut self, length: u64) -> Result<(), StateError> {
        let failed = |error| StateError::Io { path: self.path.clone(), error };
        let mut file = &self.file;
        check_length(&self.path, file.metadata().map_err(failed)?.len(), length)?;
        file.set_len(length).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
        // Arrays of a run that ended hold tables that come again.
        for later in ["npz", "npz.part"].map(|ending| self.path.with_extension(ending)) {
            match std::fs::remove_file(&later) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(StateError::Io { path: later, error });
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds rows, all or none of them.
    fn add(&mut self, rows: io::Result<Vec<u8>>) -> Result<(), ObserverError> {
        let begin = self.lengths.last().copied().unwrap_or(0);
        let added = rows.and_then(|rows| {
            self.file.write_all(&rows)?;
            Ok(begin + rows.len() as u64)
        });
        match added {
            Ok(length) => self.lengths.push(length),
            Err(error) => {
                // A full disk may have taken half of a table.
                let _ =
                    self.file.set_len(begin).and_then(|()| self.file.seek(SeekFrom::Start(begin)));
                return Err(failed(&self.path, &error));
            }
        }
        Ok(())
    }

    fn take(&mut self, table: ProfileTable) -> Result<(), ObserverError> {
        self.add(columns::rows(&self.profile, &table))?;
        self.tables.push(table);
        Ok(())
    }

    /// Takes out tables that end later than a window, and writes the arrays.
    fn close(&mut self, last_window: u64) -> Result<(), ObserverError> {
        let kept = self.tables.partition_point(|table| table.window <= last_window);
        if kept < self.tables.len() {
            self.tables.truncate(kept);
            let cut: io::Result<()> = self.file.set_len(self.lengths[kept]);
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
            state: Some(STATE_VERSION),
            watches: Watches {
                bodies: false,
                surfaces: false,
                slices: false,
                profiles: true,
                signals: false,
                log: false,
                hashes: false,
                messages: false,
                loads: false,
                timings: false,
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
        let open = if setup.goes_on() { ProfileFiles::reopen } else { ProfileFiles::open };
        let profiles = profiles.iter().map(|profile| open(&folder, profile));
        Ok(Self { profiles: profiles.collect::<Result<_, _>>()?, parameters, folder })
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let folder = self.folder.clone();
        state.relies_on(move || sync(&folder));
        self.profiles.iter_mut().try_for_each(|files| {
            let name = files.profile.name.clone();
            state.within(&name, |state| files.exchange_state(state))
        })
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
