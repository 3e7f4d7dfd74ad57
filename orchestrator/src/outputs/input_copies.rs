//! Copies of the files that a manifest names, in the folder of the run: it goes on from there, also where these
//! files have changed since, or the folder was brought elsewhere.

use super::folder::OutputError;
use std::fs;
use std::io::Write;
use std::path::Path;
use tremie_messages::scene::InputFiles;
use tremie_state::{have_same_content, write_whole};

/// Copies files into the folder `out` of a run that do not lie there yet.
///
/// # Errors
/// If one cannot be read or the disk refuses, and if one is not what its copy is: it was changed after that.
pub fn copy_inputs(out: &Path, files: &InputFiles) -> Result<(), OutputError> {
    for (path, place) in files.iter() {
        let (path, copy) = (Path::new(path), out.join(place));
        if path == copy {
            continue;
        }
        let unreadable = |error| OutputError::Unreadable { path: path.to_path_buf(), error };
        if copy.exists() {
            match have_same_content(path, &copy).map_err(unreadable)? {
                true => continue,
                false => return Err(OutputError::Changed { path: path.to_path_buf(), copy }),
            }
        }
        let content = fs::read(path).map_err(unreadable)?;
        copy.parent().map_or(Ok(()), fs::create_dir_all).map_err(OutputError::at(&copy))?;
        write_whole(&copy, |file| file.write_all(&content)).map_err(OutputError::at(&copy))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_stays_and_a_file_that_changed_after_it_is_refused() {
        let home = tempfile::tempdir().unwrap();
        let (out, file) = (home.path().join("out"), home.path().join("valve.stl"));
        fs::write(&file, "solid").unwrap();
        let mut files = InputFiles::default();
        files.add(file.to_str().unwrap());
        let copied = || fs::read_to_string(out.join("inputs/valve.stl")).unwrap();
        copy_inputs(&out, &files).unwrap();
        copy_inputs(&out, &files).unwrap();
        assert_eq!(copied(), "solid");
        fs::write(&file, "other").unwrap();
        let refused = copy_inputs(&out, &files).unwrap_err().to_string();
        assert!(refused.contains("has changed since the run began"), "{refused}");
        assert_eq!(copied(), "solid");
        // Where the copies are the files, the others are not looked at.
        let mut copies = InputFiles::default();
        copies.add(out.join("inputs/valve.stl").to_str().unwrap());
        fs::remove_file(&file).unwrap();
        copy_inputs(&out, &copies).unwrap();
        let missing = copy_inputs(&home.path().join("new"), &files).unwrap_err().to_string();
        assert!(missing.starts_with("cannot read "), "{missing}");
    }
}
