//! The observer.

use crate::document::Document;
use crate::parameters::Parameters;
use crate::parts::Parts;
use crate::resumption;
use crate::rubber::Rubber;
use crate::series::{Entry, Series};
use crate::solids::Solids;
use crate::{about, tables};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use tremie_messages::frame::{BodySample, SliceNode, SurfaceSample, VolumeHeader};
use tremie_messages::start::{Description, FrameContent, Watches};
use tremie_messages::{INTERFACE_VERSION, Problem, Stamp};
use tremie_sdk::state::{KeepsState, StateError, StateExchange};
use tremie_sdk::{
    AsObserver, ControlPipe, Moment, Observer, ObserverError, Setup, kept_file, own_file, sync,
};

/// Series of the spheres.
const BODIES: &str = "bodies";
/// Series of the parts.
const PARTS: &str = "parts";
/// Series of the polyhedra.
const POLYHEDRA: &str = "polyhedra";
/// Series of the deformable surfaces.
const RUBBER: &str = "rubber";

/// Version of the states.
const STATE_VERSION: u32 = 1;

/// Writes fields, bodies, parts and rubber as VTK files.
pub struct Fields {
    folder: PathBuf,
    /// Description of the files; open as long as this run writes them.
    _about: File,
    parameters: Parameters,
    /// Series by the base of their files' names.
    series: BTreeMap<String, Series>,
    /// Bases of the names of the volumes' files.
    volumes: BTreeSet<String>,
    parts: Option<Parts>,
    solids: Option<Solids>,
    rubber: Option<Rubber>,
    /// Written so far [bytes].
    size: u64,
}

/// Series that are no lattices.
const SURFACES: [&str; 4] = [BODIES, PARTS, POLYHEDRA, RUBBER];

fn failed(path: &Path, error: std::io::Error) -> ObserverError {
    ObserverError::output(path, &error)
}

/// The base of the names of a volume's files: its name, as far as that can stand in a file name.
fn base(volume: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    match volume.chars().map(plain).collect::<String>() {
        name if name.is_empty() || SURFACES.contains(&name.as_str()) => format!("volume_{name}"),
        name => name,
    }
}

/// All parts, or a problem of each one that cannot be read.
fn read_parts(setup: &Setup) -> Result<Option<Parts>, Vec<Problem>> {
    let parts = &setup.hello.scene.parts;
    if parts.is_empty() {
        return Ok(None);
    }
    Parts::new(parts).map(Some).map_err(|(k, error)| {
        vec![Problem::new(format!("scene.parts[{k}].geometry"), error.to_string())]
    })
}

/// Describes the files; the description is kept open: a folder that two runs were told is one run's.
fn open_about(setup: &Setup, folder: &Path) -> Result<File, ObserverError> {
    let path = folder.join("about.txt");
    let text = about::text(&setup.hello.scene);
    if setup.goes_on() {
        return Ok(kept_file(&path, text.len() as u64)?);
    }
    let mut about = own_file(&path)?;
    about.write_all(text.as_bytes()).map_err(|error| failed(&path, error))?;
    Ok(about)
}

impl Fields {
    /// Says that a state goes on from all files.
    fn rely_on_files(&mut self, state: &mut StateExchange<'_>) {
        self.series.values_mut().for_each(|series| state.relies_on(series.on_disk()));
        let folder = self.folder.clone();
        state.relies_on(move || sync(&folder.join("about.txt")).and_then(|()| sync(&folder)));
    }

    /// Goes on with the files of these moments.
    fn go_on(&mut self, kept: BTreeMap<String, Vec<Entry>>) -> Result<(), StateError> {
        resumption::check_files(&self.folder, &kept)?;
        let surfaces = SURFACES.map(String::from);
        let bases = self.volumes.iter().chain(&surfaces).chain(kept.keys()).cloned().collect();
        resumption::remove_later(&self.folder, &bases, &kept)?;
        self.series.clear();
        for (base, entries) in kept {
            let path = self.folder.join(format!("{base}.pvd"));
            let series = Series::of(&path, entries);
            let series = series.map_err(|error| StateError::Io { path, error })?;
            self.series.insert(base, series);
        }
        Ok(())
    }

    /// Writes a document as the moment `at` of a series.
    fn keep(&mut self, base: &str, at: Moment, document: Document) -> Result<(), ObserverError> {
        let ending = if SURFACES.contains(&base) { "vtp" } else { "vti" };
        let file = format!("{base}_{:06}.{ending}", at.stamp.window);
        let path = self.folder.join(&file);
        let size = document.write(&path).map_err(|error| failed(&path, error))?;
        self.size += size;
        self.note(base, at, file, size)
    }

    /// Adds a moment to a series, whose file is there.
    fn note(
        &mut self,
        base: &str,
        at: Moment,
        file: String,
        size: u64,
    ) -> Result<(), ObserverError> {
        let path = self.folder.join(format!("{base}.pvd"));
        if !self.series.contains_key(base) {
            let series = Series::create(&path).map_err(|error| failed(&path, error))?;
            self.series.insert(base.into(), series);
        }
        let Some(series) = self.series.get_mut(base) else { return Ok(()) };
        let entry = Entry { window: at.stamp.window, time: at.time, file, size };
        series.push(entry).map_err(|error| failed(&path, error))
    }

    /// Writes the parts where they are now; parts that rest need no file of their own.
    fn keep_parts(&mut self, at: Moment, bodies: &[BodySample]) -> Result<(), ObserverError> {
        let Some(parts) = &mut self.parts else { return Ok(()) };
        let moved = parts.follow(bodies);
        let before = self.series.get_mut(PARTS);
        let last = before.as_ref().and_then(|series| series.entries().last().cloned());
        match (last, before) {
            // The parts at the start are there already; of the start's frame only what moves is
            // new.
            (Some(last), _) if last.window == at.stamp.window && !moved => Ok(()),
            (Some(last), _) if last.window < at.stamp.window && !moved => {
                self.note(PARTS, at, last.file, last.size)
            }
            (Some(last), Some(series)) if last.window == at.stamp.window => {
                let path = self.folder.join(&last.file);
                let document = parts.document(at, self.parameters.compression);
                let size = document.write(&path).map_err(|error| failed(&path, error))?;
                series.rewritten(size);
                self.size += size;
                Ok(())
            }
            _ => {
                let document = parts.document(at, self.parameters.compression);
                self.keep(PARTS, at, document)
            }
        }
    }
}

impl Observer for Fields {
    const PROGRAM: &'static str = concat!("fields ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        parameters.check()?;
        read_parts(setup)?;
        Ok(Description {
            interface: INTERFACE_VERSION,
            program: Self::PROGRAM.into(),
            state: Some(STATE_VERSION),
            watches: Watches {
                bodies: true,
                surfaces: true,
                volumes: Some(parameters.wish()),
                slices: false,
                profiles: false,
                signals: false,
                log: false,
                hashes: false,
                messages: false,
                loads: false,
                timings: false,
            },
            ..Description::default()
        })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let parameters: Parameters = setup.parameters()?;
        parameters.check()?;
        let mut bases = BTreeMap::new();
        for stream in &setup.assigned()?.frames {
            if let FrameContent::Volume(grid) = &stream.content
                && let Some(other) = bases.insert(base(&grid.name), &grid.name)
            {
                let name = &grid.name;
                let text =
                    format!("files of the volumes \"{other}\" and \"{name}\" would be named alike");
                return Err(ObserverError::Other(text));
            }
        }
        let folder = parameters.path(&setup.hello.output);
        std::fs::create_dir_all(&folder).map_err(|error| failed(&folder, error))?;
        let about = open_about(setup, &folder)?;
        let parts = read_parts(setup)?;
        let solids = Solids::new(&setup.hello.scene);
        let rubber = Rubber::new(&setup.hello.scene);
        let mut fields = Self {
            folder,
            _about: about,
            parameters,
            series: BTreeMap::new(),
            volumes: bases.into_keys().collect(),
            parts,
            solids,
            rubber,
            size: 0,
        };
        if let Some(parts) = &fields.parts
            && !setup.goes_on()
        {
            let at = Moment { stamp: Stamp::default(), time: 0.0 };
            let document = parts.document(at, fields.parameters.compression);
            fields.keep(PARTS, at, document)?;
        }
        Ok(fields)
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        if !state.restores() {
            self.rely_on_files(state);
        }
        let entries =
            |(base, series): (&String, &Series)| (base.clone(), series.entries().to_vec());
        let mut kept: BTreeMap<String, Vec<Entry>> = self.series.iter().map(entries).collect();
        state.value("series", &mut kept)?;
        state.value("size", &mut self.size)?;
        if let Some(parts) = &mut self.parts {
            state.within("parts", |state| parts.exchange_state(state))?;
        }
        if state.restores() { self.go_on(kept) } else { Ok(()) }
    }

    fn bodies(
        &mut self,
        _from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        self.keep(BODIES, at, tables::bodies(at, bodies, self.parameters.compression))?;
        if let Some(solids) = &self.solids {
            let document = solids.document(at, bodies, self.parameters.compression);
            self.keep(POLYHEDRA, at, document)?;
        }
        self.keep_parts(at, bodies)
    }

    fn surfaces(
        &mut self,
        _from: &str,
        at: Moment,
        samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        let Some(rubber) = &self.rubber else { return Ok(()) };
        let document = rubber.document(at, samples, self.parameters.compression);
        self.keep(RUBBER, at, document)
    }

    fn volume(
        &mut self,
        _from: &str,
        name: &str,
        at: Moment,
        header: &VolumeHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        let document = tables::lattice(at, header, nodes, self.parameters.compression);
        self.keep(&base(name), at, document)
    }

    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError> {
        let mut counts = Vec::new();
        for (base, series) in &mut self.series {
            series.cut(last_common_window).map_err(|error| failed(&self.folder, error))?;
            counts.push(format!("{} of {base}", series.entries().len()));
        }
        let megabytes = self.size as f64 * 1e-6;
        let folder = self.parameters.folder.display();
        Ok(format!("{folder}/: frames {}, {megabytes:.1} MB", counts.join(", ")))
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsObserver<Fields>>(line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_volumes_become_names_of_files() {
        assert_eq!(base("lattice"), "lattice");
        assert_eq!(base("../a b"), "___a_b");
        assert_eq!(base("bodies"), "volume_bodies");
        assert_eq!(base(""), "volume_");
    }
}
