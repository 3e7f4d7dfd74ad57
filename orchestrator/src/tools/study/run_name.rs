//! Names of runs: hashes of all that a run's results depend on.
//!
//! A run that was made is known again by its name, also when the project has moved, or its components are given
//! more time. Threads change no result either, but a study may well ask how long a run takes with them.

use std::collections::BTreeMap;
use std::path::Path;
use toml::{Table, Value};
use xxhash_rust::xxh64::xxh64;

/// Keys of `[run]` without an effect on results.
const TIMES: [&str; 2] = ["deadline", "start_within"];
/// Key of a component without an effect on results.
const THREADS: &str = "threads";

/// A run as its resolved manifest tells it.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct NamedRun {
    /// Its name.
    pub name: String,
    /// The times that it is given.
    pub times: String,
    /// Its manifest and the files of its scene, as a hash: also of a run with other threads, and on a machine that has
    /// its programs elsewhere.
    pub content: String,
}

/// Names of runs, and hashes of the files that their manifests name.
#[derive(Default)]
pub struct RunNames {
    /// Hash of each file, by its path; `None` for what is no file.
    files: BTreeMap<String, Option<u64>>,
}

impl RunNames {
    /// The run of a resolved manifest. The contents of the files that the manifest names count, such as those of
    /// parts: another file of the same name makes another run.
    pub fn of(&mut self, resolved: &str) -> NamedRun {
        let hash = |text: &str| format!("{:016x}", xxh64(text.as_bytes(), 0));
        let Ok(mut manifest) = toml::from_str::<Table>(resolved) else {
            let (name, content) = (hash(resolved), hash(resolved));
            return NamedRun { name, times: String::new(), content };
        };
        let mut times = String::new();
        if let Some(Value::Table(run)) = manifest.get_mut("run") {
            let given: Vec<_> = TIMES.iter().map(|key| run.remove(*key)).collect();
            times = format!("{given:?}");
        }
        if let Some(scene) = manifest.get_mut("scene") {
            self.replace_paths(scene);
        }
        let content = hash(&without_threads(manifest.clone()).to_string());
        manifest.iter_mut().for_each(|(_, value)| self.replace_paths(value));
        NamedRun { name: hash(&manifest.to_string()), times, content }
    }

    /// Puts hashes of files in place of their folders. A resolved manifest has the files of its scene by
    /// absolute paths.
    fn replace_paths(&mut self, value: &mut Value) {
        match value {
            Value::String(text) if Path::new(text.as_str()).is_absolute() => {
                let read = || Some(xxh64(&std::fs::read(&*text).ok()?, 0));
                if let Some(hash) = self.files.entry(text.clone()).or_insert_with(read) {
                    let name = Path::new(text.as_str()).file_name().unwrap_or_default();
                    *text = format!("{} {hash:016x}", name.display());
                }
            }
            Value::Array(entries) => entries.iter_mut().for_each(|it| self.replace_paths(it)),
            Value::Table(table) => table.iter_mut().for_each(|(_, it)| self.replace_paths(it)),
            _ => {}
        }
    }
}

/// A manifest that leaves the threads of its components open.
fn without_threads(mut manifest: Table) -> Table {
    let components = manifest.get_mut("components").and_then(Value::as_table_mut);
    for (_, component) in components.into_iter().flatten() {
        if let Value::Table(component) = component {
            component.remove(THREADS);
        }
    }
    manifest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest(part: &Path) -> String {
        let part = part.display();
        format!(
            "[run]\nuntil = \"1 s\"\ndeadline = \"10 s\"\n[[scene.parts]]\nfile = \"{part}\"\n\
             [components.fluid]\nprogram = \"fluid-lbm\"\nthreads = 2\n"
        )
    }

    #[test]
    fn a_name_depends_on_what_changes_results_alone() {
        let homes = [(); 2].map(|()| tempfile::tempdir().unwrap());
        let files = homes.each_ref().map(|home| home.path().join("frame.stl"));
        files.iter().for_each(|file| std::fs::write(file, "solid frame").unwrap());
        let of = |text: &str| RunNames::default().of(text);
        let name = |text: &str| of(text).name;
        let here = manifest(&files[0]);
        let wanted = name(&here);
        assert_eq!(name(&manifest(&files[1])), wanted, "the same project elsewhere");
        assert_eq!(name(&here.replace("\"10 s\"", "\"60 s\"")), wanted);
        assert_ne!(name(&here.replace("\"1 s\"", "\"2 s\"")), wanted);
        let threads = here.replace("threads = 2", "threads = 8");
        assert_ne!(name(&threads), wanted, "a study of times");
        assert_eq!(of(&threads).content, of(&here).content);
        assert_ne!(of(&here.replace("\"1 s\"", "\"2 s\"")).content, of(&here).content);
        assert_ne!(name(&here.replace("fluid-lbm", "fluid-fs")), wanted);
        std::fs::write(&files[0], "solid other").unwrap();
        assert_ne!(name(&here), wanted, "another file of the same name");
        let [nowhere, elsewhere] =
            ["/none/a", "/none/b"].map(|path| name(&manifest(Path::new(path))));
        assert_ne!(nowhere, elsewhere);
    }
}
