//! Files of the run before, where a run goes on.

use crate::series::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tremie_sdk::check_length;
use tremie_sdk::state::StateError;

/// Checks that the files of all moments are there, and whole.
///
/// # Errors
/// The first that is not.
pub fn check_files(folder: &Path, kept: &BTreeMap<String, Vec<Entry>>) -> Result<(), StateError> {
    let files: BTreeMap<&String, u64> =
        kept.values().flatten().map(|entry| (&entry.file, entry.size)).collect();
    for (file, size) in files {
        let path = folder.join(file);
        match std::fs::metadata(&path) {
            Ok(metadata) => check_length(&path, metadata.len(), size)?,
            Err(error) => {
                let name = path.display();
                let text = format!("the run cannot go on without {name}, which it wrote: {error}");
                return Err(StateError::Unfit(text));
            }
        }
    }
    Ok(())
}

/// Removes what was written later than the last moment of each series.
///
/// # Errors
/// A file that cannot be removed.
pub fn remove_later(
    folder: &Path,
    bases: &BTreeSet<String>,
    kept: &BTreeMap<String, Vec<Entry>>,
) -> Result<(), StateError> {
    let last = |base: &str| kept.get(base).and_then(|entries| entries.last());
    let is_later = |name: &str| match split(name) {
        Some((base, Some(window))) => {
            bases.contains(base) && last(base).is_none_or(|last| window > last.window)
        }
        Some((base, None)) => bases.contains(base) && !kept.contains_key(base),
        None => false,
    };
    let failed = |error| StateError::Io { path: folder.to_path_buf(), error };
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.file_name().and_then(|name| name.to_str()).is_some_and(is_later) {
            std::fs::remove_file(&path).map_err(|error| StateError::Io { path, error })?;
        }
    }
    Ok(())
}

/// Base of the name of a file, and its window, which collections have not; `None` of other files.
fn split(name: &str) -> Option<(&str, Option<u64>)> {
    let (stem, ending) = name.rsplit_once('.')?;
    if ending == "pvd" {
        return Some((stem, None));
    }
    let (base, window) = stem.rsplit_once('_')?;
    let is_ours = ["vti", "vtp", "part"].contains(&ending)
        && window.len() >= 6
        && window.bytes().all(|digit| digit.is_ascii_digit());
    is_ours.then(|| Some((base, Some(window.parse().ok()?)))).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files_have_a_base_and_a_window() {
        assert_eq!(split("bodies_000012.vtp"), Some(("bodies", Some(12))));
        assert_eq!(split("a_b_1234567.vti"), Some(("a_b", Some(1_234_567))));
        assert_eq!(split("lattice_000012.part"), Some(("lattice", Some(12))));
        assert_eq!(split("parts.pvd"), Some(("parts", None)));
        for other in ["about.txt", "bodies_12.vtp", "bodies_000012.png", "view_00a012.vti", "x"] {
            assert_eq!(split(other), None, "{other}");
        }
    }
}
