//! Contents of a study file, found right as far as the file alone tells.

use super::axes::{StudyAxis, toml_text};
use super::columns::StudyColumn;
use super::file::{PlotTable, SlurmTable, StudyDocument};
use super::points;
use crate::manifest::{self, ManifestErrors, Source, is_within};
use crate::tools::slurm::check_option;
use serde_json::Value;
use std::path::{Path, PathBuf};
use tremie_messages::{Problem, nearest};

/// Most runs of a study.
const MOST_RUNS: usize = 100_000;
/// Key of the seed, which repeats change.
pub const SEED: &str = "run.seed";
/// Headings of the table of runs that no column may have.
const HEADINGS: [&str; 4] = ["point", "seed", "run", "status"];

/// A study file that was read.
#[derive(Clone, Debug)]
pub struct StudyContents {
    /// The manifest that all runs have in common.
    pub base: PathBuf,
    /// Runs of each point; `None` leaves the seed as it is.
    pub repeats: Option<u32>,
    /// The axes.
    pub axes: Vec<StudyAxis>,
    /// Changes that all runs have, key and value in TOML.
    pub set: Vec<(String, String)>,
    /// Columns, in the order of the file.
    pub columns: Vec<StudyColumn>,
    /// Plots.
    pub plots: Vec<StudyPlot>,
    /// What the runs ask of a cluster.
    pub slurm: SlurmTable,
    /// Places in the file, for messages.
    pub source: Source,
}

/// A plot of a column over a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StudyPlot {
    /// Number of the axis, and of the key among the axis's keys.
    pub x: (usize, usize),
    /// Number of the column.
    pub y: usize,
}

impl StudyContents {
    /// Reads a study file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its place.
    pub fn read(file: &Path) -> Result<Self, ManifestErrors> {
        let text = std::fs::read_to_string(file).map_err(|error| {
            let problem = Problem::new("", format!("cannot read {}: {error}", file.display()));
            let source_text = Source::default();
            let help = "give a study file; MANIFEST.md says what stands in one";
            ManifestErrors { source_text, problems: vec![problem.help(help)] }
        })?;
        Self::parse(file, text)
    }

    fn parse(file: &Path, text: String) -> Result<Self, ManifestErrors> {
        let (document, source) = manifest::read_tables::<StudyDocument>(file, text)?;
        let mut problems = Vec::new();
        let base = base(&document, file, &mut problems);
        let axis =
            |(index, table)| StudyAxis::read(table, &format!("axes[{index}]"), &mut problems);
        let axes: Vec<StudyAxis> = document.axes.iter().enumerate().map(axis).collect();
        let columns = columns(&document, &source, &mut problems);
        check_keys(&document, &axes, &mut problems);
        check_count(&document, &axes, &mut problems);
        let plots = plots(&document.plots, &axes, &columns, &mut problems);
        check_slurm(&document.slurm, &mut problems);
        if !problems.is_empty() {
            return Err(ManifestErrors { source_text: source, problems });
        }
        let set = document.set.iter().map(|(key, value)| (key.clone(), toml_text(value))).collect();
        let (repeats, slurm) = (document.repeats, document.slurm);
        Ok(Self { base, repeats, axes, set, columns, plots, slurm, source })
    }

    /// All keys of the axes.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().flat_map(|axis| axis.keys.iter().map(String::as_str))
    }
}

/// The manifest, a file.
fn base(document: &StudyDocument, file: &Path, problems: &mut Vec<Problem>) -> PathBuf {
    let Some(base) = &document.base else {
        let problem = Problem::new("base", "missing: a study needs a manifest");
        problems.push(problem.help("add base = \"manifest.toml\""));
        return PathBuf::new();
    };
    let path = file.parent().unwrap_or(Path::new("")).join(base);
    let path = if path.is_dir() { path.join("manifest.toml") } else { path };
    if !path.is_file() {
        let problem = Problem::new("base", format!("there is no file {}", path.display()));
        problems.push(problem.help("the path counts from the study file's folder"));
    }
    path
}

/// The columns, in the order of the file.
fn columns(
    document: &StudyDocument,
    source: &Source,
    problems: &mut Vec<Problem>,
) -> Vec<StudyColumn> {
    let mut columns: Vec<StudyColumn> = Vec::new();
    for (name, table) in &document.columns {
        let is_key = document.axes.iter().any(|axis| axis.key.as_ref() == Some(name));
        if HEADINGS.contains(&name.as_str()) || is_key {
            let problem = Problem::new(format!("columns.{name}"), "the table has such a heading");
            problems.push(problem.help("give the column another name"));
        }
        columns.extend(StudyColumn::read(name, table, problems));
    }
    let place = |column: &StudyColumn| source.span(&format!("columns.{}", column.name));
    columns.sort_by_key(|column| place(column).map_or(0, |span| span.start));
    columns
}

/// No key is given twice, and none lies within another.
fn check_keys(document: &StudyDocument, axes: &[StudyAxis], problems: &mut Vec<Problem>) {
    let mut given: Vec<(&str, String)> = Vec::new();
    for (key, value) in &document.set {
        if value.is_object() && !key.contains('.') {
            let message = "a table stands for a whole table of the manifest";
            let help = format!("write one key in quotes, as \"{key}.{}\" = …", first_key(value));
            problems.push(Problem::new(format!("set.{key}"), message).help(help));
        }
        given.push((key, format!("set.{key}")));
    }
    for (index, axis) in axes.iter().enumerate() {
        let is_single = document.axes[index].key.is_some();
        for (place, key) in axis.keys.iter().enumerate() {
            let list = format!("axes[{index}].keys[{place}]");
            let place = if is_single { format!("axes[{index}].key") } else { list };
            given.push((key, place));
        }
    }
    if document.repeats.is_some() {
        given.push((SEED, "repeats".into()));
    }
    for (index, (key, place)) in given.iter().enumerate() {
        let clashes = |(other, _): &&(&str, String)| is_within(key, other) || is_within(other, key);
        if let Some((other, first)) = given[..index].iter().find(clashes) {
            let message = match *key == *other {
                true => format!("{key} is changed at {first} already"),
                false => format!("{key} and {other}, which {first} changes, lie within each other"),
            };
            problems.push(Problem::new(place, message).help("leave one of the two out"));
        }
    }
}

fn first_key(table: &Value) -> &str {
    table.as_object().and_then(|table| table.keys().next()).map_or("key", String::as_str)
}

/// There is something to run, and not too much.
fn check_count(document: &StudyDocument, axes: &[StudyAxis], problems: &mut Vec<Problem>) {
    if document.repeats == Some(0) {
        let problem = Problem::new("repeats", "found 0, expected 1 or more");
        problems.push(problem.help("leave it out to make one run a point"));
    }
    let rows: Vec<usize> = axes.iter().map(|axis| axis.rows.len()).collect();
    let runs = points::count(&rows)
        .and_then(|points| points.checked_mul(document.repeats.unwrap_or(1) as usize));
    if runs.is_none_or(|runs| runs > MOST_RUNS) {
        let all = runs.map_or("too many to count".to_string(), |runs| runs.to_string());
        let message = format!("all combinations are {all} runs, expected {MOST_RUNS} at most");
        problems.push(Problem::new("axes", message).help("give the axes fewer values"));
    }
}

/// Options stand in a line of a script each.
fn check_slurm(table: &SlurmTable, problems: &mut Vec<Problem>) {
    if table.cpus == Some(0) {
        let problem = Problem::new("slurm.cpus", "found 0, expected 1 or more");
        problems.push(problem.help("leave it out for a core for each component that computes"));
    }
    for (index, option) in table.options.iter().enumerate() {
        if let Err(message) = check_option(option) {
            let problem = Problem::new(format!("slurm.options[{index}]"), message);
            problems.push(problem.help("write \"--time=1:00:00\""));
        }
    }
}

fn plots(
    tables: &[PlotTable],
    axes: &[StudyAxis],
    columns: &[StudyColumn],
    problems: &mut Vec<Problem>,
) -> Vec<StudyPlot> {
    let keys = axes.iter().flat_map(|axis| axis.keys.iter().map(String::as_str));
    let keys: Vec<&str> = keys.collect();
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    let mut plots = Vec::new();
    for (index, PlotTable { x, y }) in tables.iter().enumerate() {
        let at = format!("plots[{index}]");
        let (Some(x), Some(y)) = (x, y) else {
            let problem = Problem::new(&at, "needs x, a key of an axis, and y, a column");
            problems.push(problem.help("write x = \"run.until\" and y = \"opening\""));
            continue;
        };
        let axis = axes.iter().enumerate().find_map(|(number, axis)| {
            axis.keys.iter().position(|key| key == x).map(|key| (number, key))
        });
        let column = names.iter().position(|name| name == y);
        if axis.is_none() {
            problems.push(not_there(format!("{at}.x"), "axis changes the key", x, &keys));
        }
        if column.is_none() {
            problems.push(not_there(format!("{at}.y"), "column is called", y, &names));
        }
        let (Some(x), Some(y)) = (axis, column) else { continue };
        if axes[x.0].numbers(x.1).is_none() {
            let message = "the values of this axis are no numbers in one unit";
            let help = "give all values in one unit, or plot over another axis";
            problems.push(Problem::new(format!("{at}.x"), message).help(help));
        }
        let plot = StudyPlot { x, y };
        if plots.contains(&plot) {
            let problem = Problem::new(at, "the same plot stands here twice");
            problems.push(problem.help("leave one of them out"));
        }
        plots.push(plot);
    }
    plots
}

fn not_there(key: String, what: &str, word: &str, known: &[&str]) -> Problem {
    let problem = Problem::new(key, format!("no {what} \"{word}\""));
    problem.help(match (nearest(word, known), known) {
        (Some(near), _) => format!("did you mean \"{near}\"?"),
        (None, []) => "the study file has none".into(),
        (None, _) => format!("there are {}", known.join(", ")),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
base = "manifest.toml"
repeats = 2

[[axes]]
key = "run.until"
values = ["1 ms", "2 ms"]

[[axes]]
keys = ["a.b", "a.c"]
rows = [[1, 2], [3, 4]]

[set]
"outputs.record" = false

[columns]
speed = { signal = "grains.max_speed", of = "max" }
height = { signal = "grains.mean_height", of = "last" }

[[plots]]
x = "run.until"
y = "speed"
"#;

    fn read(text: &str) -> Result<StudyContents, ManifestErrors> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("manifest.toml"), "").unwrap();
        let file = folder.path().join("study.toml");
        std::fs::write(&file, text).unwrap();
        StudyContents::read(&file)
    }

    #[test]
    fn a_study_file_is_read() {
        let study = read(GOOD).unwrap();
        assert_eq!(study.set, [("outputs.record".to_string(), "false".to_string())]);
        assert_eq!(study.keys().collect::<Vec<_>>(), ["run.until", "a.b", "a.c"]);
        assert_eq!(study.plots, [StudyPlot { x: (0, 0), y: 0 }]);
        let names: Vec<_> = study.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["speed", "height"], "columns keep their order");
    }

    #[test]
    fn a_wrong_study_file_is_refused_with_its_line_and_a_remedy() {
        for (from, to, line, words) in [
            ("base = \"manifest.toml\"", "", 0, "needs a manifest"),
            ("manifest.toml", "other.toml", 2, "there is no file"),
            ("repeats = 2", "repeats = 0", 3, "found 0"),
            ("repeats = 2", "repeat = 2", 3, "unknown key \"repeat\""),
            ("\"a.b\"", "\"run.until\"", 10, "run.until is changed at axes[0].key already"),
            ("\"a.b\"", "\"run.seed\"", 3, "run.seed is changed at axes[1].keys[0] already"),
            ("outputs.record\"", "run\"", 6, "lie within each other"),
            ("\"outputs.record\" = false", "outputs.record = false", 14, "whole table"),
            ("speed = {", "status = {", 17, "such a heading"),
            ("of = \"max\"", "of = \"most\"", 17, "found \"most\""),
            ("x = \"run.until\"", "x = \"run.untl\"", 21, "no axis changes the key"),
            ("y = \"speed\"", "y = \"sped\"", 22, "did you mean \"speed\"?"),
            ("x = \"run.until\"", "y = \"x\"", 22, "duplicate key"),
            ("\"2 ms\"]", "\"2 s\"]", 21, "numbers in one unit"),
            ("[[plots]]", "[slurm]\ncpus = 0\n[[plots]]", 21, "found 0"),
            ("[[plots]]", "[slurm]\noptions = ['time=1']\n[[plots]]", 21, "an option of sbatch"),
        ] {
            assert!(GOOD.contains(from), "{from}");
            let error = read(&GOOD.replacen(from, to, 1)).unwrap_err().to_string();
            let has_line = line == 0 || error.contains(&format!("study.toml:{line}:"));
            assert!(has_line && error.contains(words), "{line}, {words}:\n{error}");
            assert!(error.contains("help: "), "{error}");
        }
    }

    #[test]
    fn a_study_of_endless_runs_is_refused() {
        let axis = "[[axes]]\nkey = 'k0'\nrange = { from = 1, to = 2, count = 100000 }\n";
        let axes: String = (0..5).map(|k| axis.replace("k0", &format!("k{k}"))).collect();
        let error = read(&format!("base = 'manifest.toml'\n{axes}")).unwrap_err().to_string();
        assert!(error.contains("too many to count"), "{error}");
    }
}
