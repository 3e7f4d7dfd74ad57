//! Begins the file, or goes on with that of the run before.
//!
//! A writer of MCAP cannot go on where another one stopped: it needs the index of all chunks. So they
//! are written again into a file beside the old one, record by record and with the same ends, which
//! gives the same bytes. The old file is there until the new one is as far as that was: a run that is
//! killed on the way can be resumed again.

use crate::document::RUN;
use crate::entry::Entry;
use crate::file::{Columns, Extent, Known, McapFile};
use crate::records::Records;
use crate::windows::Stream;
use crate::write_behind::Pieces;
use mcap::read::ChunkReader;
use mcap::records::Record;
use serde_json::Value;
use std::collections::BTreeMap;
use std::error::Error;
use std::fs::File;
use std::path::{Path, PathBuf};
use tremie_messages::scene::Scene;
use tremie_sdk::state::StateError;
use tremie_sdk::{ObserverError, kept_file, own_file, sync};

/// What a file begins with.
pub struct Beginning {
    /// The file.
    pub path: PathBuf,
    /// Level of compression.
    pub level: u32,
    /// The document of the run; given away to the file, which has it then.
    pub run: BTreeMap<String, String>,
}

impl Beginning {
    /// Begins the file.
    ///
    /// # Errors
    /// If it cannot be written, or somebody has it.
    pub fn create(&mut self) -> Result<McapFile, ObserverError> {
        let file = own_file(&self.path)?;
        McapFile::create(file, self.level, std::mem::take(&mut self.run))
            .map_err(|error| ObserverError::output(&self.path, &error))
    }

    /// Waits, when called, until the disk has all closed chunks, of which some are on their way. The open one stays
    /// open: where a chunk ends must not depend on when a checkpoint is made.
    pub fn on_disk(&self, pieces: Pieces) -> impl FnOnce() -> Result<(), StateError> + use<> {
        let path = self.path.clone();
        move || {
            settle(&pieces, &path)?;
            sync(&path)?;
            path.parent().filter(|folder| *folder != Path::new("")).map_or(Ok(()), sync)
        }
    }

    /// Goes on with the file of the run before, whose open chunk held `open`; `columns` has those of a
    /// stream.
    ///
    /// # Errors
    /// If the file is not there, or not as it was.
    pub fn resume<'a>(
        &mut self,
        reached: &Extent,
        open: Vec<Entry>,
        columns: impl Fn(&Stream) -> Columns<'a>,
    ) -> Result<McapFile, StateError> {
        let old = kept_file(&self.path, 0)?;
        // Nobody else may have the old file before the new one has its name.
        let _own = old.try_clone();
        // What stands behind a link is replaced, not the link.
        let path = self.path.canonicalize().map_err(|error| self.unfit(&error))?;
        let beside = beside(&path);
        let file = own_file(&beside).map_err(|error| StateError::Unfit(error.to_string()))?;
        let begun = self.copy(old, file, reached).and_then(|mut file| {
            settle(&file.pieces(), &beside)?;
            sync(&beside)?;
            std::fs::rename(&beside, &path).map_err(|error| self.unfit(&error))?;
            path.parent().map_or(Ok(()), sync)?;
            let reopened = file.reopen_chunk(reached.windows, open, columns);
            reopened.map_err(|error| self.unfit(&error))?;
            Ok(file)
        });
        if begun.is_err() {
            // Half a file is of no use, and its room may be.
            let _ = std::fs::remove_file(&beside);
        }
        begun
    }

    /// Writes the first chunks of the file `old` again, into `file`.
    fn copy(&mut self, old: File, file: File, extent: &Extent) -> Result<McapFile, StateError> {
        let mut new = McapFile::create(file, self.level, self.run.clone())
            .map_err(|error| self.unfit(&error))?;
        let mut records = Records::of(old, true).map_err(|error| self.unfit(&error))?;
        let (mut known, mut chunks) = (Known::default(), 0);
        while chunks < extent.chunks {
            match records.next().map_err(|error| self.unfit(&error))? {
                Some(Record::Metadata(metadata)) if metadata.name == RUN => {
                    self.check(&metadata.metadata)?;
                }
                Some(Record::Chunk { header, data }) => {
                    let copied = ChunkReader::new(header, &data)
                        .and_then(|records| new.copy_records(records, &mut known));
                    // The first one has nothing but channels, and is there in every file.
                    let closed = copied.and_then(|()| match chunks {
                        0 => Ok(()),
                        _ => new.close_chunk(),
                    });
                    closed.map_err(|error| self.unfit(&error))?;
                    chunks += 1;
                }
                Some(_) => {}
                None => break,
            }
        }
        let found = new.extent();
        if (chunks, found.entries) != (extent.chunks, extent.entries) {
            return Err(self.unfit_text(&format!(
                "found {} messages in {chunks} chunks, expected {} in {}, which the run wrote before",
                found.entries, extent.entries, extent.chunks
            )));
        }
        self.run.clear();
        Ok(new)
    }

    /// Checks that a file is of this run. How long it is, what it sends to observers, and what users may
    /// change from a window on may differ.
    fn check(&self, found: &BTreeMap<String, String>) -> Result<(), StateError> {
        let differs = |key: &&str| match (*key, found.get(*key), self.run.get(*key)) {
            ("scene", Some(found), Some(own)) => lasting_scene(found) != lasting_scene(own),
            (_, found, own) => found != own,
        };
        let Some(key) = ["format", "clock", "scene"].into_iter().find(differs) else {
            return Ok(());
        };
        Err(self.unfit_text(&format!("found the {key} of another run, expected this one's")))
    }

    /// An error and what caused it: a full disk is named last.
    fn unfit(&self, error: &dyn Error) -> StateError {
        let (mut words, mut cause) = (error.to_string(), error.source());
        while let Some(error) = cause {
            words = format!("{words}: {error}");
            cause = error.source();
        }
        self.unfit_text(&words)
    }

    fn unfit_text(&self, why: &str) -> StateError {
        StateError::Unfit(format!("the run cannot go on with {}: {why}", self.path.display()))
    }
}

/// Waits until the file at `path` has its pieces.
fn settle(pieces: &Pieces, path: &Path) -> Result<(), StateError> {
    pieces.settle().map_err(|error| StateError::Io { path: path.to_path_buf(), error })
}

/// The file that is written beside another until it takes its place.
fn beside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    path.with_file_name(name)
}

/// What stays of a scene for the whole run: not what drives it, nor friction. Its files count by the places of their
/// copies: recordings before 0.3 have absolute paths. Where the text is no scene, the text.
fn lasting_scene(text: &str) -> Value {
    let scene = serde_json::from_str::<Scene>(text).map(|scene| scene.with_copies());
    let Ok(mut scene) = scene.and_then(serde_json::to_value) else { return text.into() };
    let mut remove = |table: &str, keys: &[&str]| {
        let entries = match scene.pointer_mut(table) {
            Some(Value::Array(entries)) => &mut entries[..],
            Some(table) => std::slice::from_mut(table),
            None => return,
        };
        for table in entries.iter_mut().filter_map(Value::as_object_mut) {
            table.retain(|key, _| !keys.contains(&key.as_str()));
        }
    };
    remove("", &["gravity", "contacts"]);
    remove("/fluid", &["viscosity", "acceleration"]);
    remove("/domain", &["faces"]);
    remove("/parts", &["motion"]);
    remove("/bodies", &["motion"]);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face, Geometry, Motion, Part, PartBoundary, Pose};

    fn scene(mesh: &str, unit: f64) -> String {
        let mut scene = Scene::empty(Domain::new([0.0; 3], [1.0; 3], Face::WALLS));
        scene.parts.push(Part {
            name: "valve".into(),
            geometry: Geometry::File { path: mesh.into(), unit },
            pose: Pose::IDENTITY,
            cavity: false,
            material: "steel".into(),
            motion: Motion::Fixed,
            boundary: PartBoundary::Wall,
        });
        serde_json::to_string(&scene).unwrap()
    }

    #[test]
    fn files_of_a_scene_count_by_the_places_of_their_copies() {
        let lasting = |mesh, unit| lasting_scene(&scene(mesh, unit));
        let copied = lasting("inputs/valve.stl", 1e-3);
        assert_eq!(lasting("/project/valve.stl", 1e-3), copied);
        assert_ne!(lasting("/project/valve.stl", 1e-2), copied);
        assert_ne!(lasting("/project/other.stl", 1e-3), copied);
    }
}
