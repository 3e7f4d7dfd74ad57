//! Files of a series by time: ParaView's collection, kept readable while it grows.

use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use tremie_sdk::state::StateError;
use tremie_sdk::sync;

const HEAD: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
                    byte_order=\"LittleEndian\">\n  <Collection>\n";
const TAIL: &str = "  </Collection>\n</VTKFile>\n";

/// A series of files, and its collection.
pub struct Series {
    path: PathBuf,
    file: File,
    entries: Vec<Entry>,
    /// Number of moments, from the first one on, whose files the disk surely has.
    synced: usize,
    /// The same once the disk has what it was last asked for, and whether it has.
    asked: (usize, Arc<AtomicBool>),
    /// Length of the collection without its tail.
    len: u64,
}

/// A moment of a series.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Coupling window at whose end the data hold.
    pub window: u64,
    /// Simulated time [s].
    pub time: f64,
    /// Name of the file; several moments may share one.
    pub file: String,
    /// Size of the file [bytes].
    pub size: u64,
}

impl Series {
    /// An empty series at `path`, a `.pvd` file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        Self::of(path, Vec::new())
    }

    /// A series of these moments, whose files are there.
    ///
    /// # Errors
    /// If the collection cannot be written.
    pub fn of(path: &Path, entries: Vec<Entry>) -> io::Result<Self> {
        let len = write(path, &entries)?;
        let file = OpenOptions::new().write(true).open(path)?;
        let (synced, asked) = (entries.len(), Default::default());
        Ok(Self { path: path.into(), file, synced, asked, entries, len })
    }

    /// Waits, when called, until the disk has the collection and its files as they are now.
    pub fn on_disk(&mut self) -> impl FnOnce() -> Result<(), StateError> + use<> {
        let (count, has_them) = &self.asked;
        if has_them.load(Ordering::Relaxed) {
            self.synced = self.synced.max(*count);
        }
        let folder = self.folder();
        let new = &self.entries[self.synced..];
        let mut files: Vec<PathBuf> = new.iter().map(|entry| folder.join(&entry.file)).collect();
        files.dedup();
        files.push(self.path.clone());
        // What the disk refuses, or is not asked for after all, is asked for again with the next ones.
        let has_them = Arc::new(AtomicBool::new(false));
        self.asked = (self.entries.len(), has_them.clone());
        move || {
            files.iter().try_for_each(|file| sync(file))?;
            has_them.store(true, Ordering::Relaxed);
            Ok(())
        }
    }

    fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Adds a moment: one write over the tail, so that the collection is whole before and after.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn push(&mut self, entry: Entry) -> io::Result<()> {
        let line = line(&entry);
        if let Err(error) = self.put(&format!("{line}{TAIL}")) {
            // The tail had room before.
            let _ = self.put(TAIL).and_then(|()| self.file.set_len(self.len + TAIL.len() as u64));
            return Err(error);
        }
        self.len += line.len() as u64;
        self.entries.push(entry);
        Ok(())
    }

    /// Writes over the tail.
    fn put(&mut self, text: &str) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(self.len))?;
        self.file.write_all(text.as_bytes())
    }

    /// Moments so far.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The file of the last moment was written again.
    pub fn rewritten(&mut self, size: u64) {
        if let Some(last) = self.entries.last_mut() {
            last.size = size;
            self.unsure_from(self.entries.len() - 1);
        }
    }

    /// Files of the moments from a number on are others than the disk was asked for.
    fn unsure_from(&mut self, number: usize) {
        self.synced = self.synced.min(number);
        self.asked.0 = self.asked.0.min(number);
    }

    /// Takes out what is later than `window`, and removes files that nothing refers to any more.
    ///
    /// # Errors
    /// If the collection cannot be written, or a file not removed.
    pub fn cut(&mut self, window: u64) -> io::Result<()> {
        let kept = self.entries.partition_point(|entry| entry.window <= window);
        if kept == self.entries.len() {
            return Ok(());
        }
        let late = self.entries.split_off(kept);
        self.unsure_from(kept);
        self.len = write(&self.path, &self.entries)?;
        let folder = self.folder();
        let mut removed: Option<&str> = None;
        for entry in &late {
            let is_used = self.entries.iter().any(|kept| kept.file == entry.file);
            if !is_used && removed != Some(&entry.file) {
                std::fs::remove_file(folder.join(&entry.file))?;
                removed = Some(&entry.file);
            }
        }
        Ok(())
    }
}

/// Writes a whole collection; returns its length without its tail.
fn write(path: &Path, entries: &[Entry]) -> io::Result<u64> {
    let text: String = entries.iter().map(line).collect();
    std::fs::write(path, format!("{HEAD}{text}{TAIL}"))?;
    Ok((HEAD.len() + text.len()) as u64)
}

fn line(entry: &Entry) -> String {
    format!("    <DataSet timestep=\"{:e}\" part=\"0\" file=\"{}\"/>\n", entry.time, entry.file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collection_is_whole_after_each_moment_and_ends_where_it_is_cut() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bodies.pvd");
        let mut series = Series::create(&path).unwrap();
        let text = || std::fs::read_to_string(&path).unwrap();
        assert_eq!(text(), format!("{HEAD}{TAIL}"));
        // The last three moments share a file.
        for (window, file) in [(0, "a"), (5, "b"), (10, "c"), (15, "c"), (20, "c")] {
            std::fs::write(folder.path().join(file), "x").unwrap();
            series.push(Entry { window, time: window as f64, file: file.into(), size: 1 }).unwrap();
            assert!(text().ends_with(&format!("file=\"{file}\"/>\n{TAIL}")), "{}", text());
        }
        assert_eq!(text().matches("<DataSet").count(), 5);
        series.cut(10).unwrap();
        assert_eq!(text().matches("<DataSet").count(), 3);
        assert!(folder.path().join("c").exists(), "window 10 needs it");
        series.cut(5).unwrap();
        assert!(!folder.path().join("c").exists());
        series.push(Entry { window: 10, time: 10.0, file: "d".into(), size: 1 }).unwrap();
        assert_eq!(text().matches("<DataSet").count(), 3);
        assert!(text().ends_with(TAIL));
    }
}
