//! Programs of components, found by their names in a manifest.

use super::own_program::own_folder;
use crate::registry::{BuiltIn, built_in};
use std::path::{Path, PathBuf};

/// Program that runs a component.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Program {
    /// A component of this executable.
    BuiltIn(&'static str),
    /// Another program.
    File(PathBuf),
}

/// A program that a manifest names could not be found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no component \"{name}\": not built in, and no program at {}", looked.join(", "))]
pub struct MissingProgram {
    /// Name in the manifest.
    pub name: String,
    /// Places that were searched.
    pub looked: Vec<String>,
}

impl Program {
    /// Finds the program that a manifest in `folder` calls `name`: a built-in component; else a
    /// path from the manifest's folder; else a program beside this one; else one on the search
    /// path.
    ///
    /// # Errors
    /// [`MissingProgram`], with the places that were looked at.
    pub fn find(name: &str, folder: &Path) -> Result<Self, MissingProgram> {
        if let Some(BuiltIn { name, .. }) = built_in(name) {
            return Ok(Self::BuiltIn(name));
        }
        let mut places = vec![folder.join(name)];
        if !name.contains('/') {
            places.extend(own_folder().map(|beside| beside.join(name)));
            let path = std::env::var_os("PATH").unwrap_or_default();
            places.extend(std::env::split_paths(&path).map(|folder| folder.join(name)));
        }
        match places.iter().find(|place| place.is_file()) {
            Some(file) => {
                Ok(Self::File(std::path::absolute(file).unwrap_or_else(|_| file.clone())))
            }
            None => {
                let mut looked: Vec<_> =
                    places.iter().take(2).map(|p| p.display().to_string()).collect();
                if places.len() > 2 {
                    looked.push("the search path".into());
                }
                Err(MissingProgram { name: name.to_string(), looked })
            }
        }
    }
}
