//! The manifest: the TOML file that names scene, components, schedule and outputs of a run.
//!
//! [`load`] reads it in four steps, each of which keeps going after a problem so that a user sees
//! all of them at once: TOML text to a tree with places (`tree`), overrides of the command line
//! (`overrides`), tree to typed tables (`read`, `document`), tables to a checked [`Spec`]
//! (`check`). Problems point at the line they come from ([`Source`]).

mod check;
mod differences;
mod document;
mod explain;
mod hints;
mod key_help;
mod overrides;
mod path;
mod read;
mod reference;
mod render;
mod resolve;
mod source;
mod spec;
#[cfg(test)]
mod tests;
mod tree;

pub use differences::differences;
pub use key_help::{KeyBeginning, KeyHelp, key_help, keys_beginning};
pub use path::is_within;
pub use source::Source;
pub use spec::{
    Checkpoints, ComponentSpec, Limit, MOST_SUBSTEPS, Outputs, RunOptions, START_WITHIN, Spec,
    StopCondition, WatchLimit,
};

use document::Document;
use read::Findings;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tremie_messages::{Problem, nearest};

/// The orchestrator's own name in logs and streams; no component may bear it.
pub const ORCHESTRATOR: &str = "orchestrator";

/// A manifest that was read and found right, as far as that can be known without its components.
#[derive(Clone, Debug)]
pub struct Manifest {
    /// Content of the manifest, in SI units and with all defaults.
    pub spec: Spec,
    /// Place of each key, for messages.
    pub source: Source,
    /// Notes for a reader, such as on settings of programs that take no part.
    pub notes: Vec<String>,
    document: Document,
}

/// Everything that is wrong with a manifest.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}", source_text.render(problems, false))]
pub struct ManifestErrors {
    /// The text and the places in it. (Not named `source`: it is not an error's cause.)
    pub source_text: Source,
    /// The problems, at least one.
    pub problems: Vec<Problem>,
}

/// Reads the manifest at `path`, a file or a folder that holds `manifest.toml`, with `sets` of
/// `key = value` laid over it: keys as in `scene.bodies[0].density`, values in TOML, or plain
/// text where that is not TOML (`0.1 Pa s`).
///
/// # Errors
/// Every problem found, each with its place.
pub fn load(path: &Path, sets: &[(String, String)]) -> Result<Manifest, ManifestErrors> {
    let (file, text) = text_of(path)?;
    parse(&file, text, sets).map_err(|errors| errors.of_folder(&file))
}

/// Reads the tables of the manifest at `path`, as [`load`] takes it, with defaults filled in. Nothing but keys and
/// kinds of values is checked, and no file is opened that the manifest names.
///
/// # Errors
/// Every unknown key and every value of a wrong kind, each with its place.
pub fn load_tables(path: &Path) -> Result<Value, ManifestErrors> {
    let (file, text) = text_of(path)?;
    let Tables { document, findings, problems, source } = tables(&file, text, &[])?;
    settled(source, with_findings(problems, findings)).map(|_| tree_of(&document))
}

/// The file of a manifest, and its text.
fn text_of(path: &Path) -> Result<(PathBuf, String), ManifestErrors> {
    let file = if path.is_dir() { path.join("manifest.toml") } else { PathBuf::from(path) };
    match std::fs::read_to_string(&file) {
        Ok(text) => Ok((file, text)),
        Err(error) => {
            let problem = Problem::new("", format!("cannot read {}: {error}", file.display()))
                .help("give a manifest, or a folder that holds a manifest.toml");
            Err(ManifestErrors {
                source_text: Source::new(&file, String::new()),
                problems: vec![problem],
            })
        }
    }
}

/// Reads a manifest from `text`; `file` is what messages call it, and paths in the manifest are
/// relative to its folder.
///
/// # Errors
/// As [`load`].
pub fn parse(
    file: &Path,
    text: String,
    sets: &[(String, String)],
) -> Result<Manifest, ManifestErrors> {
    let Tables { document, mut findings, problems, source } = tables(file, text, sets)?;
    let spec = check::check(&document, &mut findings);
    let problems = with_findings(problems, findings);
    match spec {
        Some(spec) if problems.is_empty() => {
            let notes = check::notes(&spec);
            Ok(Manifest { spec, source, notes, document })
        }
        _ => Err(ManifestErrors { source_text: source, problems }),
    }
}

/// The tables of a manifest, not checked yet.
struct Tables {
    document: Document,
    /// What is wrong with its keys and values.
    findings: Findings,
    /// What is wrong with values of the command line.
    problems: Vec<Problem>,
    source: Source,
}

fn with_findings(mut problems: Vec<Problem>, findings: Findings) -> Vec<Problem> {
    problems.extend(findings.into_problems().into_iter().map(hints::add_hint));
    problems
}

fn tables(file: &Path, text: String, sets: &[(String, String)]) -> Result<Tables, ManifestErrors> {
    let mut source = Source::new(file, text);
    let mut problems = Vec::new();
    let mut tree = tree::read(&mut source, &mut problems);
    if !problems.is_empty() {
        // A table may have lost its header: what else looks wrong need not be so.
        return Err(ManifestErrors { source_text: source, problems });
    }
    overrides::apply(&mut tree, sets, &mut source, &mut problems);
    if is_empty(&tree) {
        let problem = Problem::new("line 1, column 1", "the manifest is empty");
        let help = "the README has a short one; `tremie scene` writes that of a valve";
        return Err(ManifestErrors { source_text: source, problems: vec![problem.help(help)] });
    }
    let (mut document, findings) = read::read::<Document>(tree);
    document.fill(file.parent().unwrap_or(Path::new("")));
    Ok(Tables { document, findings, problems, source })
}

/// Reads `text` of another file in the tables `T`, all of whose keys may be missing, as a manifest is
/// read: each value with its place. `file` is the name of the file in messages.
///
/// # Errors
/// Every problem found, each with its place.
pub fn read_tables<T: DeserializeOwned + Default>(
    file: &Path,
    text: String,
) -> Result<(T, Source), ManifestErrors> {
    let mut source = Source::new(file, text);
    let mut problems = Vec::new();
    let tree = tree::read(&mut source, &mut problems);
    let (tables, findings) = read::read(tree);
    let source = settled(source, with_findings(problems, findings))?;
    Ok((tables, source))
}

/// The source of a manifest without problems.
fn settled(source: Source, problems: Vec<Problem>) -> Result<Source, ManifestErrors> {
    if problems.is_empty() {
        Ok(source)
    } else {
        Err(ManifestErrors { source_text: source, problems })
    }
}

/// Plain tables, strings and finite numbers: JSON has a form for each of them.
fn tree_of(document: &Document) -> Value {
    serde_json::to_value(document).unwrap_or_default()
}

fn is_empty(tree: &Value) -> bool {
    tree.as_object().is_some_and(serde_json::Map::is_empty)
}

/// The JSON schema of manifests, for editors and other programs.
pub fn schema_text() -> String {
    format!("{:#}", resolve::schema())
}

/// The reference page of the manifest, in Markdown.
pub fn reference_page() -> String {
    reference::page(&resolve::schema())
}

impl Manifest {
    /// Its tables as they were understood, defaults filled in.
    pub fn tables(&self) -> Value {
        tree_of(&self.document)
    }

    /// Gives problems of `component`, whose keys are relative to its settings or those of the scene
    /// as components see it, the keys of the manifest.
    pub fn absolute(&self, component: &str, problems: Vec<Problem>) -> Vec<Problem> {
        let Some(component) = self.spec.component(component) else {
            return problems;
        };
        let own = path::join(&component.key(), "settings");
        let shared = path::join("settings", component.stem());
        let mut told: Vec<Problem> = Vec::new();
        for mut problem in problems {
            self.name_missing_field(component, &mut problem);
            if let Some(key) = problem.key.strip_prefix(Problem::PARAMETER_PREFIX) {
                let of = |program: &str| path::join(&path::join("settings", program), key);
                let also = crate::registry::settings_shared_with(component.stem()).map(of);
                let (own, shared) = (path::join(&own, key), path::join(&shared, key));
                let all = [own, shared].into_iter().chain(also);
                let known = all.into_iter().find(|key| self.source.knows(key));
                problem.key = known.unwrap_or_else(|| self.settings_key(component, key));
            } else {
                problem.key = self.written(&problem.key);
            }
            let problem = hints::add_hint(problem);
            // One remedy for one key is one problem, such as that of a cell along three axes.
            let same = |other: &Problem| (&other.key, &other.help) == (&problem.key, &problem.help);
            if problem.help.is_none() || !told.iter().any(same) {
                told.push(problem);
            }
        }
        told
    }

    /// Words a setting that is missing as other keys that are; serde's sentence on it names no table.
    fn name_missing_field(&self, component: &ComponentSpec, problem: &mut Problem) {
        let field = problem.message.strip_prefix("missing field `");
        let Some(field) = field.and_then(|rest| rest.strip_suffix('`')) else { return };
        let inner = problem.key.strip_prefix(Problem::PARAMETER_PREFIX).unwrap_or(&problem.key);
        let key = path::join(inner, field);
        let table = path::join("settings", component.stem());
        let names: Vec<&str> = self.spec.settings.keys().map(String::as_str).collect();
        let message = format!("missing: {} needs a key \"{field}\"", path::join(&table, inner));
        let written = nearest(component.stem(), &names).filter(|name| *name != component.stem());
        *problem = match written {
            Some(name) => Problem::new(path::join("settings", name), message)
                .help(format!("did you mean [{table}]?")),
            None => Problem::of_parameter(&key, message),
        };
    }

    /// The key of the manifest for one of the scene: bodies have their `placement` by `packing`,
    /// `spheres`, `cylinders` or `polyhedra` there.
    fn written(&self, key: &str) -> String {
        let names = [
            (".placement.polyhedra.placement.packed", ".packing"),
            (".placement.polyhedra.placement.listed", ".polyhedra"),
            (".placement.polyhedra.shape", ".shape"),
            (".placement.packed", ".packing"),
            (".placement.listed", ".spheres"),
        ];
        let key = names
            .iter()
            .fold(key.to_string(), |key, (of_scene, own)| key.replacen(of_scene, own, 1));
        let words = ["packing", "spheres", "cylinders", "polyhedra", "lattice"];
        let either = words.map(|word| key.replacen("placement", word, 1));
        // What is listed may be cylinders.
        let listed = [key.replacen(".spheres", ".cylinders", 1)];
        either.into_iter().chain(listed).find(|either| self.source.knows(either)).unwrap_or(key)
    }

    /// Key under which a key that the manifest does not hold would be written: in the component's
    /// settings.
    fn settings_key(&self, component: &ComponentSpec, key: &str) -> String {
        let own = path::join(&component.key(), "settings");
        let table =
            if self.source.knows(&own) { own } else { path::join("settings", component.stem()) };
        if self.source.knows(&table) { path::join(&table, key) } else { component.key() }
    }
}

impl ManifestErrors {
    /// Files beside a manifest whose folder is no text cannot be told to anybody: then that is what
    /// is wrong.
    fn of_folder(mut self, file: &Path) -> Self {
        let path = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        if path.to_str().is_none() {
            let is_lossy =
                |problem: &&mut Problem| problem.message.contains(char::REPLACEMENT_CHARACTER);
            for problem in self.problems.iter_mut().filter(is_lossy) {
                problem.message = format!(
                    "the manifest's folder, {path:?}, is no UTF-8 text, which components must be told"
                );
                problem.help = Some("move the manifest and its files to another folder".into());
            }
        }
        self
    }

    /// As [`Source::render`].
    pub fn render(&self, colour: bool) -> String {
        self.source_text.render(&self.problems, colour)
    }

    /// As [`Source::json_lines`].
    pub fn json_lines(&self) -> String {
        self.source_text.json_lines(&self.problems)
    }
}
