//! Scenes that are ready: texts of examples, and a scene that a package builds from numbers.

use super::annotate::{ManifestHead, first_changes, with_head, with_table_comments};
use super::write_file;
use crate::registry::SCENES;
use std::ffi::OsStr;
use std::path::Path;
use tremie_results::CommandError;

/// A scene to begin with.
#[derive(Debug)]
pub struct Template {
    /// Its name on the command line.
    pub name: &'static str,
    /// What happens in it, in a sentence.
    pub about: &'static str,
    source: SceneSource,
}

/// Where a scene comes from.
#[derive(Debug)]
enum SceneSource {
    /// The text of a manifest.
    Text(&'static str),
    /// A scene of a package, by its name, and the keys that are to be changed first.
    Package(&'static str, &'static [&'static str]),
}

/// All scenes that are ready. The first is the one that `tremie new` takes where it is told none.
pub const TEMPLATES: [Template; 3] = [
    Template {
        name: "dam-break",
        about: "A column of water collapses, with light and heavy spheres in it, and runs around a post.",
        source: SceneSource::Text(include_str!("../../../../examples/dam-break/short.toml")),
    },
    Template {
        name: "packed-bed",
        about: "Grains settle to a bed, and a viscous fluid seeps up through it.",
        source: SceneSource::Text(include_str!("templates/packed-bed.toml")),
    },
    Template {
        name: "valve",
        about: "A piston pushes a fluid through a spring-loaded valve with a rubber seal, and stops. Half of the valve: x = 0 is \
                a mirror.",
        source: SceneSource::Package(
            "pressure-valve",
            &[
                "scene.domain.z.lower.reservoir.piston",
                "scene.fluid.viscosity",
                "scene.parts.motion.slider.spring.rate",
                "scene.parts.motion.slider.mass",
                "run.until",
            ],
        ),
    },
];

/// What the files of a valve are.
const VALVE_FILES: [(&str, &str); 10] = [
    ("manifest.toml", "the scene, with comments"),
    ("rigid.toml", "the same with a rigid ring"),
    ("grains.toml", "the same with grains in the fluid"),
    ("held.toml", "a steady flow, the valve held open"),
    (
        "dimensions.toml",
        "the numbers of the valve: tremie scene pressure-valve --set KEY=VALUE makes another",
    ),
    ("frame.stl", "conduit, bore, seat and chamber, in millimetres"),
    ("valve.stl", "plug and disc, to look at"),
    ("ring.stl", "the ring, to look at"),
    ("ring.toml", "the ring of rubber: tremie rubber make-table makes its table"),
    ("ring.json", "its table of force and shapes"),
];

impl Template {
    /// Writes the scene into a folder; gives the files.
    ///
    /// # Errors
    /// The system's.
    pub fn write(
        &self,
        head: &ManifestHead,
        folder: &Path,
    ) -> Result<Vec<(String, String)>, CommandError> {
        let head = head.text(self.about);
        let (text, files): (String, &[_]) = match self.source {
            SceneSource::Text(text) => (with_head(text, &head), &VALVE_FILES[..1]),
            SceneSource::Package(scene, keys) => {
                build(scene, folder)?;
                let manifest = folder.join("manifest.toml");
                let built = std::fs::read_to_string(&manifest).map_err(|error| {
                    CommandError::failed(format!("cannot read {}: {error}", manifest.display()))
                })?;
                let head = format!("{head}\n{}", first_changes(keys));
                (with_table_comments(&with_head(&built, &head)), &VALVE_FILES)
            }
        };
        write_file(folder, "manifest.toml", text.as_bytes())?;
        Ok(files.iter().map(|(name, what)| ((*name).into(), (*what).into())).collect())
    }
}

/// Lets a package build its scene, in the form that takes minutes.
fn build(scene: &str, folder: &Path) -> Result<(), CommandError> {
    let package = SCENES.iter().find(|package| package.name == scene);
    let package =
        package.ok_or_else(|| CommandError::failed(format!("there is no scene {scene}")))?;
    let command = (package.arguments)(clap::Command::new(package.name));
    let words = [package.name, "--coarse", "--"].map(OsStr::new);
    let words = words.into_iter().chain([folder.as_os_str()]);
    let matches = command.try_get_matches_from(words).map_err(CommandError::failed)?;
    (package.work)(&matches).map(|_| ())
}

#[cfg(test)]
mod tests {
    use super::super::tests::arguments;
    use super::*;
    use crate::manifest;

    /// Each is written whole, and read without a complaint.
    #[test]
    fn templates_are_manifests() {
        for template in &TEMPLATES {
            let home = tempfile::tempdir().unwrap();
            let arguments = arguments(Path::new("mine"), template.name);
            let head = ManifestHead { name: "mine".into(), arguments: &arguments };
            let files = template.write(&head, home.path()).unwrap();
            for (file, _) in &files {
                assert!(home.path().join(file).is_file(), "{}: {file}", template.name);
            }
            let there = std::fs::read_dir(home.path()).unwrap().count();
            assert_eq!(there, files.len(), "{}: {files:?}", template.name);
            let text = std::fs::read_to_string(home.path().join("manifest.toml")).unwrap();
            assert!(text.starts_with("# mine: ") && text.contains("tremie explain "), "{text}");
            let comments = text.lines().filter(|line| line.contains('#')).count();
            assert!(comments > 20, "{}: {comments} comments", template.name);
            if let Err(errors) = manifest::load(home.path(), &[]) {
                panic!("{}: {errors}", template.name);
            }
        }
    }
}
