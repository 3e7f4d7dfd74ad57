//! Checks of the surfaces of parts: whether files can be read, where the parts are, how large.

use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{Domain, Geometry, Part};

/// Notes each part whose file is not there.
pub(super) fn check(_domain: &Domain, parts: &[Option<Part>], findings: &mut Findings) {
    for (i, part) in parts.iter().enumerate() {
        if let Some(Part { geometry: Geometry::File { path: file, .. }, .. }) = part
            && let Err(error) = std::fs::File::open(file)
        {
            let key = path::join(&path::item("scene.parts", i), "file");
            findings.problem(&key, format!("cannot read {file}: {error}"));
        }
    }
}
