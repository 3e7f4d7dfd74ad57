//! Files of outputs that a checkpoint relies on.

use crate::observer::lock;
use std::fs::{File, OpenOptions};
use std::path::Path;
use tremie_state::StateError;

/// Opens the file at `path` as the run before left it, for this process alone as long as it is kept
/// open. Its first `length` bytes are those of the checkpoint; what follows them is later, and stays.
///
/// # Errors
/// If it is not there or shorter, or somebody has it.
pub fn kept_file(path: &Path, length: u64) -> Result<File, StateError> {
    let name = path.display();
    let unfit = |error: std::io::Error| {
        StateError::Unfit(format!("the run cannot go on with {name}, which it wrote: {error}"))
    };
    let file = OpenOptions::new().read(true).write(true).open(path).map_err(unfit)?;
    let metadata = file.metadata().map_err(unfit)?;
    if !metadata.is_file() {
        return Err(StateError::Unfit(format!("the run cannot go on with {name}: it is no file")));
    }
    check_length(path, metadata.len(), length)?;
    lock(&file, path).map_err(StateError::Unfit)?;
    Ok(file)
}

/// Checks that a file of `found` bytes has the `length` that it had at the checkpoint.
///
/// # Errors
/// If it is shorter.
pub fn check_length(path: &Path, found: u64, length: u64) -> Result<(), StateError> {
    if found >= length {
        return Ok(());
    }
    Err(StateError::Unfit(format!(
        "{} holds {found} bytes, expected the {length} of the checkpoint: the run cannot go on \
         without them",
        path.display()
    )))
}

/// Waits until the disk has the file at `path`, or the names in the folder there. A state may rely
/// on them after that, even if the power fails.
///
/// # Errors
/// If the disk refuses.
pub fn sync(path: &Path) -> Result<(), StateError> {
    let failed = |error| StateError::Io { path: path.to_path_buf(), error };
    let metadata = std::fs::metadata(path).map_err(failed)?;
    // Pipes and devices have nothing to wait for.
    if !metadata.is_file() && !metadata.is_dir() {
        return Ok(());
    }
    File::open(path).and_then(|file| file.sync_all()).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_gone_on_with_only_if_it_holds_what_the_checkpoint_had() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.csv");
        let why = |length| kept_file(&path, length).unwrap_err().to_string();
        assert!(why(0).contains("rows.csv"), "{}", why(0));
        std::fs::write(&path, "twelve bytes").unwrap();
        assert!(why(13).contains("rows.csv holds 12 bytes, expected the 13"), "{}", why(13));
        let kept = kept_file(&path, 12).unwrap();
        assert!(why(12).contains("is being written by another run"), "{}", why(12));
        drop(kept);
        assert!(kept_file(&path, 3).is_ok());
        assert_eq!(std::fs::read(&path).unwrap(), b"twelve bytes", "nothing is cut off");
        assert!(kept_file(folder.path(), 0).is_err());
        sync(&path).and_then(|()| sync(folder.path())).unwrap();
        assert!(sync(&folder.path().join("none")).is_err());
    }
}
