//! The folder of a run's outputs.

use std::io;
use std::path::{Path, PathBuf};

/// An output could not be written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The folder that the user chose holds something.
    #[error("{0} holds something already; choose another --out, or remove it")]
    Occupied(PathBuf),
    /// The operating system refuses.
    #[error("cannot write {path}: {error}")]
    Io {
        /// What was written.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
    /// A table could not be written.
    #[error("cannot write the table of signals: {0}")]
    Table(#[from] csv::Error),
}

impl OutputError {
    /// For `map_err` at `path`.
    pub(super) fn at(path: &Path) -> impl Fn(io::Error) -> Self {
        let path = path.to_path_buf();
        move |error| Self::Io { path: path.clone(), error }
    }
}

/// Makes the folder of a run: `out` if the user chose one, else `runs/NAME-001` and so on, where
/// NAME is the manifest's folder or file.
///
/// # Errors
/// If the chosen folder holds something already, or none can be made.
pub fn choose_folder(out: Option<&Path>, manifest: &Path) -> Result<PathBuf, OutputError> {
    if let Some(folder) = out {
        std::fs::create_dir_all(folder).map_err(OutputError::at(folder))?;
        let mut entries = std::fs::read_dir(folder).map_err(OutputError::at(folder))?;
        return match entries.next() {
            Some(_) => Err(OutputError::Occupied(folder.to_path_buf())),
            None => Ok(folder.to_path_buf()),
        };
    }
    let runs = Path::new("runs");
    std::fs::create_dir_all(runs).map_err(OutputError::at(runs))?;
    let name = scenario_name(manifest);
    for number in 1.. {
        let folder = runs.join(format!("{name}-{number:03}"));
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(OutputError::at(&folder)(error)),
        }
    }
    Err(OutputError::Occupied(runs.to_path_buf()))
}

/// `settling-sphere` of `examples/settling-sphere/manifest.toml`, `short` of `.../short.toml`.
fn scenario_name(manifest: &Path) -> String {
    let manifest = std::path::absolute(manifest).unwrap_or_else(|_| manifest.to_path_buf());
    let named = match manifest.file_name().and_then(|name| name.to_str()) {
        Some("manifest.toml") => manifest.parent().and_then(Path::file_name),
        _ => manifest.file_stem(),
    };
    named.map_or_else(|| "run".into(), |name| name.to_string_lossy().into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_called_by_its_scenario() {
        assert_eq!(scenario_name(Path::new("examples/settling-sphere")), "settling-sphere");
        assert_eq!(scenario_name(Path::new("examples/bed/manifest.toml")), "bed");
        assert_eq!(scenario_name(Path::new("examples/bed/short.toml")), "short");
    }

    #[test]
    fn a_folder_that_holds_something_is_refused() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        assert_eq!(choose_folder(Some(&out), Path::new("m")).unwrap(), out);
        std::fs::write(out.join("a"), "b").unwrap();
        assert!(matches!(choose_folder(Some(&out), Path::new("m")), Err(OutputError::Occupied(_))));
    }
}
