//! Runs of a study: the manifest of each, checked, and the name of its folder.

use super::StudyError;
use super::axes::value_text;
use super::contents::{SEED, StudyContents};
use super::points;
use super::run_name::RunNames;
use super::threads::RunThreads;
use crate::manifest::{self, Manifest, ManifestErrors, Source, is_within};
use serde_json::Value;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use tremie_messages::Problem;

/// A run of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyRun {
    /// Its point, counted from 1.
    pub point: usize,
    /// Its seed, where the study repeats points.
    pub seed: Option<u32>,
    /// Row of each axis, counted from 0.
    pub rows: Vec<usize>,
    /// Values of all keys of the axes.
    pub values: Vec<Value>,
    /// Changes of the manifest: key and value in TOML.
    pub sets: Vec<(String, String)>,
    /// Name of its folder.
    pub name: String,
    /// Its manifest and the files of its scene, as a hash.
    pub content: String,
    /// Threads of its components.
    pub threads: RunThreads,
    /// The times that it is given, on which its results and its name do not depend.
    pub times: String,
}

impl StudyRun {
    /// Its values in words, for messages.
    pub fn words(&self, contents: &StudyContents) -> String {
        let values = contents.keys().zip(&self.values);
        let values = values.map(|(key, value)| format!("{key} = {}", value_text(value)));
        let seed = self.seed.map(|seed| format!("seed {seed}"));
        values.chain(seed).collect::<Vec<_>>().join(", ")
    }
}

/// Checks the manifests of all runs of a study; returns the runs, and the first one's manifest.
///
/// # Errors
/// Everything that is wrong with any of them, or an interrupt.
pub fn checked_runs(
    contents: &StudyContents,
    interrupts: &AtomicUsize,
) -> Result<(Vec<StudyRun>, Manifest), StudyError> {
    let text = std::fs::read_to_string(&contents.base)
        .map_err(|error| StudyError::Io { path: contents.base.clone(), error })?;
    let mut names = RunNames::default();
    let mut faults = Faults::default();
    let (mut runs, mut first) = (Vec::new(), None);
    for mut run in all_runs(contents) {
        if interrupts.load(Ordering::Relaxed) > 0 {
            return Err(StudyError::Interrupted);
        }
        match manifest::parse(&contents.base, text.clone(), &run.sets) {
            Ok(mut manifest) => {
                let named = names.of(&manifest.resolved());
                (run.name, run.times, run.content) = (named.name, named.times, named.content);
                manifest.spec.add_output_observers();
                run.threads = RunThreads::of(&manifest.spec);
                first.get_or_insert(manifest);
            }
            Err(errors) => faults.add(contents, &run, errors),
        }
        runs.push(run);
    }
    faults.finish(contents, runs.len())?;
    check_twins(contents, &runs)?;
    // A study has a point at least.
    first.map(|first| (runs, first)).ok_or(StudyError::Input(Vec::new()))
}

/// All runs, point by point, without names.
fn all_runs(contents: &StudyContents) -> impl Iterator<Item = StudyRun> + '_ {
    let rows: Vec<usize> = contents.axes.iter().map(|axis| axis.rows.len()).collect();
    let points = points::count(&rows).unwrap_or(0);
    (0..points).flat_map(move |point| {
        let rows = points::rows_at(point, &rows);
        let seeds: Vec<Option<u32>> = match contents.repeats {
            Some(repeats) => (1..=repeats).map(Some).collect(),
            None => vec![None],
        };
        seeds.into_iter().map(move |seed| run_at(contents, point, rows.clone(), seed))
    })
}

fn run_at(contents: &StudyContents, point: usize, rows: Vec<usize>, seed: Option<u32>) -> StudyRun {
    let of_axes = contents.axes.iter().zip(&rows);
    let values: Vec<Value> = of_axes.flat_map(|(axis, row)| axis.rows[*row].clone()).collect();
    let keys = contents.keys().map(String::from);
    let changes = keys.zip(values.iter().map(super::axes::toml_text));
    let seeds = seed.map(|seed| (SEED.to_string(), seed.to_string()));
    let sets = contents.set.iter().cloned().chain(changes).chain(seeds).collect();
    StudyRun { point: point + 1, seed, rows, values, sets, ..StudyRun::default() }
}

/// No two runs are the same.
fn check_twins(contents: &StudyContents, runs: &[StudyRun]) -> Result<(), StudyError> {
    let mut seen: BTreeMap<&str, &StudyRun> = BTreeMap::new();
    let mut problems: Vec<Problem> = Vec::new();
    for run in runs {
        let Some(other) = seen.insert(&run.name, run) else { continue };
        if problems.iter().any(|problem| problem.message.contains("are the same run")) {
            continue;
        }
        let message = format!(
            "points {} and {} are the same run: {}; {}",
            other.point,
            run.point,
            other.words(contents),
            run.words(contents)
        );
        let help = "leave one of the values out: they mean the same in another unit or spelling, or change no result, as run.deadline";
        problems.push(Problem::new("axes", message).help(help));
    }
    if problems.is_empty() {
        return Ok(());
    }
    let source_text = contents.source.clone();
    Err(StudyError::Input(vec![ManifestErrors { source_text, problems }]))
}

/// What is wrong with the manifests of runs, each problem once.
#[derive(Default)]
struct Faults {
    /// Problems of values in the study file.
    of_study: Vec<Problem>,
    /// Other problems, the run of each, and how often they were found.
    of_base: Vec<(Problem, StudyRun, usize)>,
    base: Option<Source>,
}

impl Faults {
    fn add(&mut self, contents: &StudyContents, run: &StudyRun, errors: ManifestErrors) {
        for problem in errors.problems {
            match place_of(contents, run, &problem) {
                Some(place) => {
                    let message = format!("{}: {}", problem.key, problem.message);
                    let placed = Problem { key: place, message, help: problem.help };
                    if !self.of_study.contains(&placed) {
                        self.of_study.push(placed);
                    }
                }
                None => match self.of_base.iter_mut().find(|(other, ..)| *other == problem) {
                    Some((.., count)) => *count += 1,
                    None => self.of_base.push((problem, run.clone(), 1)),
                },
            }
        }
        self.base.get_or_insert(errors.source_text);
    }

    /// # Errors
    /// All of them, if there are any.
    fn finish(self, contents: &StudyContents, runs: usize) -> Result<(), StudyError> {
        let noted = |(mut problem, run, count): (Problem, StudyRun, usize)| {
            // A fault of all runs is one of the manifest alone.
            if count < runs {
                problem.message += &format!(" (with {})", run.words(contents));
            }
            problem
        };
        let of_base: Vec<Problem> = self.of_base.into_iter().map(noted).collect();
        let (study, base) = (contents.source.clone(), self.base.unwrap_or_default());
        let all = [(study, self.of_study), (base, of_base)]
            .map(|(source_text, problems)| ManifestErrors { source_text, problems });
        let found: Vec<_> = all.into_iter().filter(|all| !all.problems.is_empty()).collect();
        if found.is_empty() { Ok(()) } else { Err(StudyError::Input(found)) }
    }
}

/// Key of the study file whose value a problem blames; `None` if it is none of the study file's.
fn place_of(contents: &StudyContents, run: &StudyRun, problem: &Problem) -> Option<String> {
    let blames = |key: &str| {
        let is_unknown = problem.message.starts_with("unknown key");
        is_within(&problem.key, key) || (is_unknown && is_within(key, &problem.key))
    };
    let of_axes = contents.axes.iter().zip(&run.rows).find_map(|(axis, row)| {
        let column = axis.keys.iter().position(|key| blames(key))?;
        Some(axis.place(*row, column))
    });
    let of_set = || contents.set.iter().find(|(key, _)| blames(key));
    of_axes.or_else(|| of_set().map(|(key, _)| format!("set.{key}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    const BASE: &str = r#"
[run]
until = "1 ms"
[scene.domain]
size = ["10 mm", "10 mm", "10 mm"]
[[scene.bodies]]
name = "ball"
density = "2500 kg/m3"
spheres = [{ position = ["5 mm", "5 mm", "8 mm"], diameter = "1 mm" }]
[[scene.contacts]]
normal_stiffness = "1000 N/m"
tangential_stiffness = "800 N/m"
friction = 0.3
restitution = 0.8
[components]
grains = "grains-dem"
[settings.grains-dem]
time_step = "1 us"
"#;

    fn runs(study: &str) -> Result<Vec<StudyRun>, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("base.toml"), BASE).unwrap();
        let file: PathBuf = folder.path().join("study.toml");
        std::fs::write(&file, format!("base = 'base.toml'\n{study}")).unwrap();
        let contents = StudyContents::read(&file).map_err(|errors| errors.to_string())?;
        let checked = checked_runs(&contents, &AtomicUsize::new(0));
        checked.map(|(runs, _)| runs).map_err(|error| error.to_string())
    }

    #[test]
    fn runs_come_point_by_point_with_their_seeds() {
        let runs =
            runs("repeats = 2\n[[axes]]\nkey = 'run.until'\nvalues = ['1 ms', '2 ms']").unwrap();
        let all: Vec<_> = runs.iter().map(|run| (run.point, run.seed.unwrap())).collect();
        assert_eq!(all, [(1, 1), (1, 2), (2, 1), (2, 2)]);
        let names: std::collections::BTreeSet<_> = runs.iter().map(|run| &run.name).collect();
        assert_eq!(names.len(), 4);
        assert_eq!(
            runs[3].sets,
            [("run.until".into(), "\"2 ms\"".into()), ("run.seed".into(), "2".into())]
        );
    }

    #[test]
    fn the_same_run_has_the_same_name_in_other_studies() {
        let one = runs("[[axes]]\nkey = 'run.until'\nvalues = ['1 ms', '2 ms']").unwrap();
        let other = runs("[set]\n'run.until' = '2000 us'").unwrap();
        assert_eq!(one[1].name, other[0].name);
        assert_ne!(one[0].name, other[0].name);
    }

    #[test]
    fn wrong_values_are_told_at_their_place_in_the_study_file() {
        for (study, places) in [
            (
                "[[axes]]\nkey = 'run.until'\nvalues = ['1 ms', '2 mm', '3 kg']",
                &[
                    "study.toml:4:",
                    "axes[0].values[1]: run.until: found \"2 mm\"",
                    "axes[0].values[2]",
                ][..],
            ),
            (
                "[[axes]]\nkey = 'run.untl'\nvalues = ['1 ms']",
                &["study.toml:4:", "unknown key \"untl\"", "did you mean \"until\"?"][..],
            ),
            (
                "[[axes]]\nkey = 'scene.bodies[1].density'\nvalues = ['1 kg/m3']",
                &["study.toml:4:", "counted from 0"][..],
            ),
            ("[set]\n'scene.gravty' = 1", &["study.toml:3:", "unknown key \"gravty\""][..]),
            (
                "[[axes]]\nkey = 'run.until'\nvalues = ['1 ms', '1000 us']",
                &["points 1 and 2 are the same run"][..],
            ),
        ] {
            let error = runs(study).unwrap_err();
            assert!(places.iter().all(|place| error.contains(place)), "{study}:\n{error}");
        }
    }

    #[test]
    fn a_fault_of_some_points_elsewhere_names_one() {
        let size = "[[axes]]\nkey = 'scene.domain.size[2]'\nvalues = ['5 mm', '10 mm']";
        let error = runs(size).unwrap_err();
        assert!(
            error.contains("base.toml") && error.contains("(with scene.domain.size[2] = 5 mm)"),
            "{error}"
        );
    }
}
