//! Files that a reader finds whole: the old one or the new one.

use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

/// A file that is written beside its place. One that is dropped is removed.
#[derive(Debug)]
pub struct PreparedFile {
    path: PathBuf,
    /// The file beside; `None` once it is in its place.
    part: Option<PathBuf>,
}

impl PreparedFile {
    /// Writes a file beside the place at `path`.
    ///
    /// # Errors
    /// If the disk refuses, or `fill` fails.
    pub fn fill(
        path: &Path,
        fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<Self> {
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(".part");
        let part = path.with_file_name(name);
        let file = File::create(&part)?;
        let prepared = Self { path: path.to_path_buf(), part: Some(part) };
        let mut file = BufWriter::new(file);
        fill(&mut file)?;
        file.into_inner()?.sync_data()?;
        Ok(prepared)
    }

    /// Moves the file to its place: a reader finds the old one or this one.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn place(mut self) -> io::Result<()> {
        let Some(part) = &self.part else { return Ok(()) };
        fs::rename(part, &self.path)?;
        self.part = None;
        Ok(())
    }
}

impl Drop for PreparedFile {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            let _ = fs::remove_file(part);
        }
    }
}

/// Writes a file anew. A full disk, a kill and a power cut leave the old one as it was.
///
/// # Errors
/// If the disk refuses, or `fill` fails.
pub fn write_whole(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    PreparedFile::fill(path, fill)?.place()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn a_file_that_cannot_be_filled_stays_as_it_was() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("scene.json");
        write_whole(&path, |file| file.write_all(b"old")).unwrap();
        let full = |file: &mut BufWriter<File>| {
            file.write_all(b"ne")?;
            Err(io::ErrorKind::StorageFull.into())
        };
        assert_eq!(write_whole(&path, full).unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write_whole(&path, |file| file.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1);
        assert!(write_whole(&home.path().join("none/scene.json"), |_| Ok(())).is_err());
    }
}
