//! A state as a file: an archive that NumPy reads.

use crate::error::StateError;
use crate::exchange::{EntryReader, EntrySource, KeepsState, StateExchange, damaged};
use crate::numpy;
use crate::parts::{PARTS_STAND_STILL, StatePart, StatePlace, await_parts, part_file};
use crate::saved::{Content, SavedEntry, SavedState};
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Whose state a file holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateHeader {
    /// Name of the component in its run.
    pub component: String,
    /// Name of the program, without its version.
    pub program: String,
    /// [`KeepsState::STATE_VERSION`].
    pub version: u32,
    /// Window at whose end the state was kept.
    pub window: u64,
    /// Which part of the state the file holds.
    #[serde(default)]
    pub part: StatePart,
}

impl StateHeader {
    /// Of a state in one file.
    pub fn whole(component: &str, program: &str, version: u32, window: u64) -> Self {
        let (component, program) = (component.to_string(), program.to_string());
        Self { component, program, version, window, part: StatePart::default() }
    }
}

/// Name of the entry of the header.
const ABOUT: &str = "about.json";
const ARRAY: &str = ".npy";
const VALUE: &str = ".postcard";

impl SavedState {
    /// Writes the state into a new file, and waits until the disk has it. Of a state in parts this is the first, and
    /// the wait is also for the others. Returns the length of the file, or of all [bytes].
    ///
    /// # Errors
    /// If the file is there already, or the disk refuses; then no file is left. Other parts that do not come.
    pub fn write(&self, path: &Path, header: &StateHeader) -> Result<u64, StateError> {
        let bytes = self.write_file(path, header)?;
        Ok(bytes + await_parts(path, self.part.of, PARTS_STAND_STILL)?)
    }

    /// Writes the part of a state that this process has, beside the first one, and waits until the disk has it.
    ///
    /// # Errors
    /// If the disk refuses. Whoever waits for the part finds the error in a file of its own.
    pub fn write_part(&self, place: &StatePlace) -> Result<(), StateError> {
        let path = part_file(&place.path, self.part.number);
        let unfinished = path.with_extension("unfinished");
        let failed = |error| StateError::Io { path: path.clone(), error };
        let written = self
            .write_file(&unfinished, &place.header)
            .and_then(|_| std::fs::rename(&unfinished, &path).map_err(failed));
        if let Err(error) = &written {
            // Where this fails, too, the wait for the part ends by its deadline.
            let _ = std::fs::write(path.with_extension("failed"), error.to_string());
        }
        written
    }

    fn write_file(&self, path: &Path, header: &StateHeader) -> Result<u64, StateError> {
        let failed = |error| StateError::Io { path: path.to_path_buf(), error };
        let header = &StateHeader { part: self.part, ..header.clone() };
        let file = File::create_new(path).map_err(failed)?;
        let written = self.fill(file, header);
        if written.is_err() {
            // Half a state is of no use, and its room may be.
            let _ = std::fs::remove_file(path);
        }
        written.map_err(failed)
    }

    fn fill(&self, file: File, header: &StateHeader) -> io::Result<u64> {
        let mut archive = ZipWriter::new(BufWriter::with_capacity(PIECE, file));
        let about = serde_json::to_vec_pretty(header)?;
        archive.start_file(ABOUT, numpy::stored(about.len()))?;
        archive.write_all(&about)?;
        // What all parts have alike, the first keeps.
        let is_kept = |entry: &&SavedEntry| self.part.number == 0 || entry.is_shared;
        for SavedEntry { name, content, bytes, .. } in self.entries.iter().filter(is_kept) {
            match content {
                Content::Array { number, shape } => {
                    let header = numpy::header(number, shape);
                    let length = header.len() + bytes.len();
                    archive.start_file(format!("{name}{ARRAY}"), numpy::stored(length))?;
                    archive.write_all(&header)?;
                }
                Content::Value => {
                    archive.start_file(format!("{name}{VALUE}"), numpy::stored(bytes.len()))?
                }
            }
            archive.write_all(bytes)?;
        }
        let file = archive.finish()?.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.sync_all()?;
        Ok(file.metadata()?.len())
    }
}

/// Bytes that are written at once.
const PIECE: usize = 1 << 20;

/// A file of a state, opened to be put back.
pub struct StateArchive {
    path: PathBuf,
    archive: ZipArchive<BufReader<File>>,
    header: StateHeader,
    /// The other parts, once they were opened.
    parts: Vec<Option<ZipArchive<BufReader<File>>>>,
}

impl StateArchive {
    /// Opens a file.
    ///
    /// # Errors
    /// If there is none, or it is no state.
    pub fn open(path: &Path) -> Result<Self, StateError> {
        let (archive, header) = open_file(path)?;
        let StatePart { number, of } = header.part;
        if number != 0 || of == 0 || of > MOST_PARTS {
            return Err(damaged(ABOUT, format!("it is part {number} of {of}, not the first")));
        }
        let parts = (1..of).map(|_| None).collect();
        Ok(Self { path: path.to_path_buf(), archive, header, parts })
    }

    /// A part of the state, the first included.
    fn part(&mut self, number: usize) -> Result<&mut ZipArchive<BufReader<File>>, StateError> {
        let Some(place) = number.checked_sub(1) else { return Ok(&mut self.archive) };
        let path = part_file(&self.path, number as u32);
        if self.parts[place].is_none() {
            let (archive, header) = open_file(&path)?;
            let StatePart { of, .. } = self.header.part;
            let part = StatePart { number: number as u32, of };
            if header != (StateHeader { part, ..self.header.clone() }) {
                let why = "it is no part of the state beside it";
                return Err(damaged(&path.display().to_string(), why));
            }
            self.parts[place] = Some(archive);
        }
        self.parts[place].as_mut().ok_or_else(|| damaged(ABOUT, "a part is missing"))
    }

    /// Whose state it is.
    pub fn header(&self) -> &StateHeader {
        &self.header
    }

    /// Puts the state back into a component that was made anew from the same scene.
    ///
    /// # Errors
    /// A damaged state, or that of another scene or version; the component is of no use then.
    pub fn restore<T: KeepsState>(
        &mut self,
        program: &str,
        component: &mut T,
    ) -> Result<(), StateError> {
        self.put_back(program, T::STATE_VERSION, |state| component.exchange_state(state))
    }

    /// Puts the state back where `tell` names it, of a program whose states have this version.
    ///
    /// # Errors
    /// As [`StateArchive::restore`].
    pub fn put_back(
        &mut self,
        program: &str,
        version: u32,
        tell: impl FnOnce(&mut StateExchange<'_>) -> Result<(), StateError>,
    ) -> Result<(), StateError> {
        let say = |program: &str, version: u32| format!("{program} (state version {version})");
        let StateHeader { program: found, version: kept, .. } = &self.header;
        if found != program || *kept != version {
            let (found, expected) = (say(found, *kept), say(program, version));
            return Err(StateError::Foreign { found, expected });
        }
        let (path, header, within) = (self.path.clone(), self.header.clone(), String::new());
        let place = StatePlace { path, header, within };
        let mut exchange = StateExchange::restoring(self, Some(&place));
        tell(&mut exchange)?;
        exchange.end()
    }
}

/// Most parts of a state that are believed.
const MOST_PARTS: u32 = 1 << 16;

/// Opens one file.
fn open_file(path: &Path) -> Result<(ZipArchive<BufReader<File>>, StateHeader), StateError> {
    let failed = |error| StateError::Io { path: path.to_path_buf(), error };
    let mut file = File::open(path).map_err(failed)?;
    check_directory(&mut file).map_err(failed)?;
    let mut archive = ZipArchive::new(BufReader::with_capacity(PIECE, file))
        .map_err(|error| failed(error.into()))?;
    let header = read_header(&mut archive)?;
    Ok((archive, header))
}

/// Checks the number of entries that the end of an archive of more than 4 GB says: the library takes
/// memory for so many before it has seen one, and a program that gets none is ended.
fn check_directory(file: &mut (impl Read + Seek)) -> io::Result<()> {
    /// Length of the last records: where the end of a large archive is, and the end.
    const LAST: u64 = 20 + 22;
    /// Least length of an entry in the directory.
    const ENTRY: u64 = 46;
    /// Place of the number of entries in the end of a large archive.
    const NUMBER: u64 = 32;
    let length = file.seek(SeekFrom::End(0))?;
    let mut last = [0; LAST as usize];
    if length >= LAST {
        file.seek(SeekFrom::Start(length - LAST))?;
        file.read_exact(&mut last)?;
    }
    let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |sum, byte| sum << 8 | u64::from(*byte));
    if last.starts_with(b"PK\x06\x07") {
        let damaged = || io::Error::new(io::ErrorKind::InvalidData, "its end is damaged");
        let place = number(&last[8..16]).checked_add(NUMBER).filter(|place| *place < length);
        file.seek(SeekFrom::Start(place.ok_or_else(damaged)?))?;
        let mut entries = [0; 8];
        file.read_exact(&mut entries)?;
        if number(&entries) > length / ENTRY {
            return Err(damaged());
        }
    }
    file.rewind()
}

fn read_header(archive: &mut ZipArchive<impl Read + Seek>) -> Result<StateHeader, StateError> {
    let entry = archive.by_name(ABOUT).map_err(|error| damaged(ABOUT, error))?;
    let mut text = Vec::new();
    entry.take(MOST_ABOUT).read_to_end(&mut text).map_err(|error| damaged(ABOUT, error))?;
    serde_json::from_slice(&text).map_err(|error| damaged(ABOUT, error))
}

/// Longest header of a state [bytes].
const MOST_ABOUT: u64 = 1 << 16;

impl EntrySource for StateArchive {
    fn parts(&self) -> usize {
        1 + self.parts.len()
    }

    fn open(&mut self, name: &str, part: usize) -> Result<Option<EntryReader<'_>>, StateError> {
        let path = if part == 0 { self.path.clone() } else { part_file(&self.path, part as u32) };
        let room = std::fs::metadata(path).map_or(0, |file| file.len());
        let archive = self.part(part)?;
        let array = format!("{name}{ARRAY}");
        let is_array = archive.index_for_name(&array).is_some();
        let file = if is_array { array } else { format!("{name}{VALUE}") };
        let Some(index) = archive.index_for_name(&file) else { return Ok(None) };
        let mut entry = archive.by_index(index).map_err(|error| damaged(name, error))?;
        // What an entry says of its length may be wrong; memory is taken for it.
        if entry.compression() != CompressionMethod::Stored || entry.size() > room {
            return Err(damaged(name, "it is longer than the file"));
        }
        let size = entry.size() as usize;
        if !is_array {
            return Ok(Some(EntryReader {
                content: Content::Value,
                length: size,
                bytes: Box::new(entry),
            }));
        }
        let (content, begun) = read_array_header(name, &mut entry)?;
        let length =
            size.checked_sub(begun).ok_or_else(|| damaged(name, "it ends in its header"))?;
        Ok(Some(EntryReader { content, length, bytes: Box::new(entry) }))
    }

    fn names(&self) -> Vec<String> {
        let of = |file: &str| {
            let name =
                file.strip_suffix(ARRAY).or_else(|| file.strip_suffix(VALUE)).unwrap_or(file);
            (file != ABOUT).then(|| name.to_string())
        };
        self.archive.file_names().filter_map(of).collect()
    }
}

/// What an array holds, and the length of its header.
fn read_array_header(name: &str, entry: &mut impl Read) -> Result<(Content, usize), StateError> {
    let mut start = [0; numpy::START];
    entry.read_exact(&mut start).map_err(|error| damaged(name, error))?;
    let length =
        numpy::literal_length(&start).ok_or_else(|| damaged(name, "it is no array of NumPy's"))?;
    let mut literal = vec![0; length];
    entry.read_exact(&mut literal).map_err(|error| damaged(name, error))?;
    let text = String::from_utf8_lossy(&literal);
    let (number, shape) =
        numpy::parse(&text).ok_or_else(|| damaged(name, format!("its header is {text}")))?;
    Ok((Content::Array { number, shape }, numpy::START + length))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The end of an archive of more than 4 GB that says how many entries there are.
    fn large(entries: u64) -> Vec<u8> {
        let mut bytes = vec![0; 200];
        let end = bytes.len() as u64;
        bytes.extend_from_slice(b"PK\x06\x06");
        bytes.extend_from_slice(&44_u64.to_le_bytes());
        bytes.resize(bytes.len() + 12, 0);
        for number in [entries, entries, 46, entries] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        bytes.extend_from_slice(b"PK\x06\x07\0\0\0\0");
        bytes.extend_from_slice(&end.to_le_bytes());
        bytes.extend_from_slice(&1_u32.to_le_bytes());
        bytes.extend_from_slice(b"PK\x05\x06");
        bytes.resize(bytes.len() + 18, 0xff);
        bytes
    }

    #[test]
    fn an_end_that_says_more_entries_than_there_can_be_is_refused() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("grains.npz");
        for entries in [1 << 33, 1 << 40, u64::MAX] {
            std::fs::write(&path, large(entries)).unwrap();
            let error = StateArchive::open(&path).err().map(|error| error.to_string());
            assert!(error.is_some_and(|text| text.contains("its end is damaged")), "{entries}");
        }
        assert!(check_directory(&mut io::Cursor::new(large(3))).is_ok());
        assert!(check_directory(&mut io::Cursor::new(Vec::new())).is_ok());
    }
}
