//! The text of a manifest and where in it each key stands.

use super::path;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// The text of a manifest, the overrides laid over it, and where each key stands.
#[derive(Clone, Debug, Default)]
pub struct Source {
    pub(super) file: String,
    pub(super) text: String,
    places: BTreeMap<String, KeyPlace>,
}

/// Place of a key.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum KeyPlace {
    /// In the file, in bytes.
    File {
        /// The key itself, if it has one.
        key: Option<Range<usize>>,
        /// Its value; the header of a table.
        value: Range<usize>,
    },
    /// On the command line, in those words.
    CommandLine(String),
}

impl Source {
    pub(super) fn new(file: &Path, text: String) -> Self {
        Self { file: file.display().to_string(), text, places: BTreeMap::new() }
    }

    /// The file, as messages call it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The file's text as read.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Bytes of the value of `key` in the text; `None` where the file does not hold it, or the
    /// command line replaced it.
    pub fn span(&self, key: &str) -> Option<Range<usize>> {
        match self.places.get(key)? {
            KeyPlace::File { value, .. } => Some(value.clone()),
            KeyPlace::CommandLine(_) => None,
        }
    }

    pub(super) fn put(&mut self, key: String, place: KeyPlace) {
        self.places.insert(key, place);
    }

    /// Forgets all that stood at and below `key`.
    pub(super) fn forget(&mut self, key: &str) {
        self.places.retain(|path, _| !path::is_within(path, key));
    }

    pub(super) fn knows(&self, key: &str) -> bool {
        self.places.contains_key(key)
    }

    /// The place of `key`, or of the nearest table around it, with whether it is the key's own.
    pub(super) fn place(&self, key: &str) -> Option<(&KeyPlace, bool)> {
        let mut path = key;
        while !path.is_empty() {
            if let Some(place) = self.places.get(path) {
                return Some((place, path == key));
            }
            path = path::parent(path);
        }
        None
    }
}
