//! The files that a scene names, and their copies in the folder of a run.

use super::{Geometry, Scene};
use std::collections::BTreeMap;
use std::path::Path;

/// Folder of the copies, in that of a run.
pub const INPUTS: &str = "inputs";

/// Files that a run is made of besides its manifest, and the places of their copies in its folder.
///
/// Whoever collects the files of a scene finds the same places, also where they are the copies already.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct InputFiles {
    /// Places of copies, as `inputs/frame.stl`, by the paths of files.
    places: BTreeMap<String, String>,
}

impl InputFiles {
    /// Adds the file at `path`.
    pub fn add(&mut self, path: &str) {
        if self.places.contains_key(path) {
            return;
        }
        let part = |of: fn(&Path) -> Option<&std::ffi::OsStr>| {
            of(Path::new(path)).unwrap_or_default().to_string_lossy().into_owned()
        };
        let (stem, ending) = (part(Path::file_stem), part(Path::extension));
        let dot = if ending.is_empty() { "" } else { "." };
        let numbered = (2..).map(|number| format!("{INPUTS}/{stem}-{number}{dot}{ending}"));
        let own = format!("{INPUTS}/{stem}{dot}{ending}");
        let is_free = |place: &String| self.places.values().all(|taken| taken != place);
        // There are more numbers than files.
        if let Some(place) = std::iter::once(own).chain(numbered).find(is_free) {
            self.places.insert(path.into(), place);
        }
    }

    /// Place of the copy of the file at `path`.
    pub fn place(&self, path: &str) -> Option<&str> {
        self.places.get(path).map(String::as_str)
    }

    /// Paths of all files, each with the place of its copy.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.places.iter().map(|(path, place)| (path.as_str(), place.as_str()))
    }
}

impl Scene {
    /// Its files: meshes of parts and tables of surfaces.
    pub fn input_files(&self) -> InputFiles {
        let mut files = InputFiles::default();
        for part in &self.parts {
            if let Geometry::File { path, .. } = &part.geometry {
                files.add(path);
            }
        }
        self.surfaces.iter().for_each(|surface| files.add(&surface.table));
        files
    }

    /// The scene with the places of copies instead of its files: it is the same wherever the run is.
    pub fn with_copies(&self) -> Self {
        let (files, mut scene) = (self.input_files(), self.clone());
        for path in scene.paths() {
            *path = files.place(path).unwrap_or(path).to_string();
        }
        scene
    }

    /// The scene with its relative paths taken from the folder of its run.
    pub fn in_folder(mut self, folder: &Path) -> Self {
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
        for path in self.paths() {
            *path = folder.join(&*path).to_string_lossy().into_owned();
        }
        self
    }

    /// Paths of its files.
    fn paths(&mut self) -> impl Iterator<Item = &mut String> {
        let of_parts = self.parts.iter_mut().filter_map(|part| path_of(&mut part.geometry));
        of_parts.chain(self.surfaces.iter_mut().map(|surface| &mut surface.table))
    }
}

fn path_of(geometry: &mut Geometry) -> Option<&mut String> {
    match geometry {
        Geometry::File { path, .. } => Some(path),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn places(paths: &[&str]) -> Vec<String> {
        let mut files = InputFiles::default();
        paths.iter().for_each(|path| files.add(path));
        assert_eq!(files.iter().count(), files.places.len());
        paths.iter().map(|path| files.place(path).unwrap().to_string()).collect()
    }

    #[test]
    fn copies_of_files_have_places_of_their_own_and_keep_them() {
        let paths = ["/a/frame.stl", "/b/frame.stl", "/a/frame.stl", "/c/frame-2.stl", "/d/ring"];
        let found = places(&paths);
        let expected = ["frame.stl", "frame-2.stl", "frame.stl", "frame-2-2.stl", "ring"];
        assert_eq!(found, expected.map(|name| format!("inputs/{name}")));
        // The copies of the copies lie where they are.
        let copies: Vec<String> = found.iter().map(|place| format!("/run/{place}")).collect();
        let again = places(&copies.iter().map(String::as_str).collect::<Vec<_>>());
        assert_eq!(again, found);
    }
}
