//! Studies: tables of many runs, broken off and begun again, with failures and wrong files.

use crate::running::Running;
use crate::tremie::{SMALL, tremie};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;
use tempfile::TempDir;

/// Four points of small runs on one thread each.
pub const STUDY: &str = r#"
base = "base.toml"

[[axes]]
key = "scene.fluid.viscosity"
values = ["0.05 Pa s", "0.08 Pa s"]

[[axes]]
keys = ["scene.contacts[0].friction", "scene.contacts[0].restitution"]
rows = [[0.3, 0.5], [0.1, 0.9]]

[set]
"components.fluid.threads" = 1
"components.grains.threads" = 1

[columns]
speed = { signal = "grains.max_speed", of = "max" }
late = { signal = "grains.max_speed", of = "mean", from = "10 ms" }
start = { signal = "grains.max_speed", of = "crossing", above = 1e-3 }
never = { signal = "grains.max_speed", of = "crossing", above = 1e9 }

[[plots]]
x = "scene.fluid.viscosity"
y = "speed"
"#;

/// One run, long enough to be broken off after a checkpoint.
pub const WITH_CHECKPOINTS: &str = r#"
base = "base.toml"

[set]
"run.until" = "0.4 s"
"run.checkpoints.windows" = 200
"components.fluid.threads" = 1
"components.grains.threads" = 1

[columns]
speed = { signal = "grains.max_speed", of = "mean" }
"#;

/// A folder with the small manifest and a study of it.
pub struct Home(TempDir);

impl Home {
    pub fn new(study: &str) -> Self {
        let home = Self(tempfile::tempdir().unwrap());
        std::fs::write(home.path().join("base.toml"), SMALL).unwrap();
        std::fs::write(home.path().join("study.toml"), study).unwrap();
        home
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    pub fn command(&self, options: &[&str]) -> Command {
        let mut command = tremie();
        command.current_dir(self.path()).args(["study", "study.toml"]).args(options);
        command
    }

    pub fn study(&self, options: &[&str]) -> Output {
        self.command(options).output().unwrap()
    }

    /// A table of the study in a folder.
    pub fn table(&self, out: &str, name: &str) -> String {
        std::fs::read_to_string(self.path().join(out).join(name)).unwrap()
    }

    /// Rows of the typed table of the study in a folder.
    fn typed(&self, out: &str) -> Vec<Row> {
        let file = std::fs::File::open(self.path().join(out).join("runs.parquet")).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        reader.get_row_iter(None).unwrap().map(Result::unwrap).collect()
    }

    /// Records of the whole checkpoints of the first run.
    pub fn checkpoints(&self, out: &str) -> Vec<PathBuf> {
        let runs = std::fs::read_dir(self.path().join(out).join("runs"));
        let run = runs.into_iter().flatten().flatten().next();
        let found = run.map(|run| std::fs::read_dir(run.path().join("checkpoints")));
        let folders = found.into_iter().flatten().flatten().flatten();
        let records = folders.map(|folder| folder.path().join("checkpoint.json"));
        records.filter(|record| record.exists()).collect()
    }

    /// Folders of runs that have a summary.
    pub fn ended(&self, out: &str) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.path().join(out).join("runs"));
        let folders = entries.into_iter().flatten().flatten().map(|entry| entry.path());
        folders.filter(|folder| folder.join("summary.json").exists()).collect()
    }
}

pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// A field of a typed table as a cell of the other.
fn cell(field: &Field) -> String {
    match field {
        Field::Null => String::new(),
        Field::Long(number) => number.to_string(),
        Field::Str(text) => text.clone(),
        Field::Double(number) => serde_json::Number::from_f64(*number).unwrap().to_string(),
        other => panic!("{other:?}"),
    }
}

/// The typed table has the heads and cells of the other, numbers as numbers.
fn holds_the_same(typed: &[Row], table: &str) {
    let mut lines = table.lines();
    let heads: Vec<_> = lines.next().unwrap().split(',').map(String::from).collect();
    let wanted: Vec<Vec<_>> =
        lines.map(|line| line.split(',').map(String::from).collect()).collect();
    assert_eq!(typed.len(), wanted.len());
    for (row, wanted) in typed.iter().zip(wanted) {
        let (names, cells): (Vec<_>, Vec<_>) =
            row.get_column_iter().map(|(name, field)| (name.clone(), cell(field))).unzip();
        assert_eq!((names, cells), (heads.clone(), wanted));
    }
}

/// Rows of a table, without the heading.
fn rows(table: &str) -> Vec<Vec<String>> {
    let row = |line: &str| line.split(',').map(String::from).collect();
    table.lines().skip(1).map(row).collect()
}

#[test]
fn a_study_makes_a_row_for_each_run() {
    let home = Home::new(STUDY);
    let output = home.study(&["--out", "out"]);
    assert!(output.status.success(), "{}", errors(&output));
    assert!(errors(&output).contains("4 of 4 runs are done, 4 made now"), "{}", errors(&output));
    let table = home.table("out", "runs.csv");
    let heads = "point,seed,scene.fluid.viscosity,scene.contacts[0].friction,scene.contacts[0].restitution,run,status,speed [m/s],late [m/s],start [s],never [s]";
    assert_eq!(table.lines().next(), Some(heads));
    let rows = rows(&table);
    let begin = |row: &Vec<String>| row[..5].join(",");
    assert_eq!(
        rows.iter().map(begin).collect::<Vec<_>>(),
        [
            "1,,0.05 Pa s,0.3,0.5",
            "2,,0.05 Pa s,0.1,0.9",
            "3,,0.08 Pa s,0.3,0.5",
            "4,,0.08 Pa s,0.1,0.9"
        ]
    );
    for row in &rows {
        let speed: f64 = row[7].parse().unwrap();
        let start: f64 = row[9].parse().unwrap();
        assert!(row[6] == "completed" && speed > 1e-3 && start > 0.0, "{row:?}");
        assert_eq!(row[10], "", "a bound that is never met leaves its cell empty");
    }
    assert!(
        rows[0][7].parse::<f64>().unwrap() > rows[2][7].parse::<f64>().unwrap(),
        "thick oil is slower"
    );
    let typed = home.typed("out");
    holds_the_same(&typed, &table);
    let numbers = |row: &Row| {
        row.get_column_iter()
            .map(|(_, field)| matches!(field, Field::Double(_)))
            .collect::<Vec<_>>()
    };
    // Point, seed, viscosity with its unit, friction, restitution, run, status; three of the four columns.
    let are = [false, false, false, true, true, false, false, true, true, true, false];
    assert_eq!(numbers(&typed[0]), are);
    let times = home.table("out", "times.csv");
    assert!(times.starts_with("point,seed,run,wall_time [s]\n1,,"), "{times}");
    assert_eq!(times.lines().count(), 5);
    let plot = home.table("out", "speed-over-scene-fluid-viscosity.svg");
    assert!(plot.contains("contacts[0].friction") || plot.contains("friction = 0.3"), "{plot}");

    // Nothing is made twice, and other points of the file reuse what is there.
    let output = home.study(&["--out", "out"]);
    assert!(errors(&output).contains("4 of 4 runs are done, 0 made now"), "{}", errors(&output));
    assert_eq!(home.table("out", "runs.csv"), table);
    let more = STUDY.replace("[0.1, 0.9]]", "[0.1, 0.9], [0.2, 0.9]]");
    std::fs::write(home.path().join("study.toml"), more).unwrap();
    let output = home.study(&["--out", "out", "--jobs", "2"]);
    assert!(errors(&output).contains("6 of 6 runs are done, 2 made now"), "{}", errors(&output));
    assert_eq!(home.table("out", "runs.csv").lines().count(), 7);
}

#[test]
fn seeds_repeat_a_point_in_the_folder_of_the_study() {
    let study = "base = \"base.toml\"\nrepeats = 2\n[columns]\nspeed = { signal = \"grains.max_speed\", of = \"last\" }\n";
    let home = Home::new(study);
    let output = home.study(&["--json"]);
    assert!(output.status.success(), "{}", errors(&output));
    let name = home.path().file_name().unwrap().to_string_lossy().into_owned();
    let rows = rows(&home.table(&format!("studies/{name}"), "runs.csv"));
    let begin: Vec<_> = rows.iter().map(|row| row[..2].join(" ")).collect();
    assert_eq!(begin, ["1 1", "1 2"]);
    let events: Vec<serde_json::Value> =
        said(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &str| events.iter().filter(|event| event["event"] == kind).count();
    assert_eq!((of("run"), of("end"), of("failure")), (2, 1, 0), "{events:?}");
}

/// Wherever a study is killed, the next one ends with the bytes of one that nothing disturbed.
#[test]
fn a_study_that_is_killed_goes_on_to_the_same_table() {
    let home = Home::new(STUDY);
    let output = home.study(&["--out", "whole"]);
    assert!(output.status.success(), "{}", errors(&output));
    for (number, ended) in [0, 1, 3].into_iter().enumerate() {
        let out = format!("killed-{number}");
        let mut command = home.command(&["--out", &out, "--jobs", "1"]);
        let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        crate::running::until("runs", || {
            let begun = std::fs::read_dir(home.path().join(&out).join("runs"));
            let begun = begun.map_or(0, |runs| runs.flatten().count());
            home.ended(&out).len() >= ended && begun > ended
        });
        running.send("-KILL");
        running.wait(Duration::from_secs(60));
        assert!(home.ended(&out).len() < 4, "it was killed too late");
        let output = home.study(&["--out", &out]);
        assert!(output.status.success(), "{}", errors(&output));
        assert_eq!(home.table(&out, "runs.csv"), home.table("whole", "runs.csv"), "{out}");
        let typed = |out: &str| std::fs::read(home.path().join(out).join("runs.parquet")).unwrap();
        assert!(typed(&out) == typed("whole"), "{out}");
    }
}

/// A run of a study that was killed after a checkpoint goes on from it, by the study or by a printed
/// line, and ends with the bytes of an undisturbed one. With a checkpoint that is damaged it begins
/// again. It has as many threads as the command that goes on gives it.
#[test]
fn a_run_that_was_broken_off_goes_on_from_its_checkpoint() {
    let home = Home::new(&WITH_CHECKPOINTS.replace("\"components.grains.threads\" = 1\n", ""));
    assert!(home.study(&["--out", "whole"]).status.success());
    let signals = |out: &str| std::fs::read(home.ended(out)[0].join("signals.csv")).unwrap();
    for way in ["study", "print", "damaged"] {
        let checkpoints = || home.checkpoints(way);
        // More jobs than cores: a thread for each component.
        let mut command = home.command(&["--out", way, "--jobs", "4096"]);
        let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
        crate::running::until("a checkpoint", || !checkpoints().is_empty());
        running.send("-KILL");
        running.wait(Duration::from_secs(60));
        // The run ends in order, with a last checkpoint, when its study is gone.
        crate::running::until("the run's end", || !home.ended(way).is_empty());
        let summary = std::fs::read_to_string(home.ended(way)[0].join("summary.json")).unwrap();
        assert!(summary.contains("interrupted"), "{way}: it was killed too late");
        match way {
            "print" => {
                let line = said(&home.study(&["--out", way, "--print"]));
                assert!(line.split(" || ").next().unwrap().contains(" resume "), "{line}");
                assert!(Command::new("sh").args(["-c", &line]).status().unwrap().success());
            }
            "damaged" => {
                checkpoints().iter().for_each(|record| std::fs::write(record, "{").unwrap());
            }
            _ => {}
        }
        let output = home.study(&["--out", way]);
        assert!(output.status.success(), "{way}: {}", errors(&output));
        assert_eq!(signals(way), signals("whole"), "{way}");
        assert_eq!(home.table(way, "runs.csv"), home.table("whole", "runs.csv"), "{way}");
        let log = std::fs::read_to_string(home.ended(way)[0].join("log.jsonl")).unwrap();
        assert_eq!(log.contains("the run goes on from"), way != "damaged", "{way}: {log}");
        let manifest = std::fs::read_to_string(home.ended(way)[0].join("manifest.toml")).unwrap();
        let manifest: toml::Table = manifest.parse().unwrap();
        let threads = manifest["components"]["grains"].get("threads");
        let cores = std::thread::available_parallelism().unwrap().get() as i64;
        match way {
            "study" => assert_eq!(threads, Some(&cores.into())),
            "print" => assert_eq!(threads, Some(&1.into()), "the line leaves them as they are"),
            _ => assert_eq!(threads, None, "it began again"),
        }
    }
}

#[test]
fn a_study_that_is_interrupted_says_how_to_go_on() {
    let study = STUDY.replace(
        "\"components.fluid.threads\"",
        "\"run.until\" = \"20 s\"\n\"components.fluid.threads\"",
    );
    let home = Home::new(&study);
    // A script that starts tests in the background has them ignore -INT, which a child inherits.
    let mut command = Command::new("env");
    command.arg("--default-signal=INT").arg(tremie().get_program()).current_dir(home.path());
    command.args(["study", "study.toml", "--out", "out", "--jobs", "1"]);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut running = Running::start(&mut command);
    crate::running::until("a run", || {
        let runs = std::fs::read_dir(home.path().join("out/runs"));
        let has_table = |run: std::fs::DirEntry| run.path().join("signals.csv").exists();
        runs.is_ok_and(|runs| runs.flatten().any(has_table))
    });
    // The folder is this study's.
    let output = home.study(&["--out", "out"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        errors(&output).contains("belongs to a study that is under way"),
        "{}",
        errors(&output)
    );
    running.send("-INT");
    assert_eq!(running.wait(Duration::from_secs(60)), Some(130));
    let errors = running.errors();
    assert!(errors.contains("runs under way end in order: 1"), "{errors}");
    assert!(errors.contains("interrupted: 0 of 4 runs are done"), "{errors}");
    assert!(errors.contains("`tremie study study.toml --out out --jobs 1` goes on"), "{errors}");
    assert_eq!(home.table("out", "runs.csv").lines().count(), 1, "{errors}");
}

/// A viscosity with which the lattice refuses to begin, among others.
#[test]
fn a_point_that_fails_is_told_and_the_others_are_made() {
    let study = STUDY.replace("\"0.08 Pa s\"", "\"1e-12 Pa s\", \"0.08 Pa s\"");
    let home = Home::new(&study.replace("rows = [[0.3, 0.5], [0.1, 0.9]]", "rows = [[0.3, 0.5]]"));
    let output = home.study(&["--out", "out"]);
    let words = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("run 2 of 3 failed: scene.fluid.viscosity = 1e-12 Pa s"), "{words}");
    assert!(words.contains("2 of 3 runs are done, 3 made now, 1 failed"), "{words}");
    assert!(words.contains("makes the failed ones again"), "{words}");
    let rows = rows(&home.table("out", "runs.csv"));
    let statuses: Vec<_> = rows.iter().map(|row| row[6].as_str()).collect();
    assert_eq!(statuses, ["completed", "failed", "completed"]);
    assert_eq!(rows[1][7..], ["", "", "", ""]);
    holds_the_same(&home.typed("out"), &home.table("out", "runs.csv"));
    let output = home.study(&["--out", "out"]);
    assert!(errors(&output).contains("1 made now, 1 failed"), "{}", errors(&output));
}

#[test]
fn wrong_studies_are_refused_before_anything_runs() {
    // A plot would want its axis in one unit.
    let (study, _) = STUDY.split_once("[[plots]]").unwrap();
    for (from, to, words) in [
        (
            "0.08 Pa s",
            "0.08 m",
            &["study.toml:6:", "axes[0].values[1]: scene.fluid.viscosity: found \"0.08 m\""][..],
        ),
        (
            "fluid.viscosity\"\nvalues",
            "fluid.viscosty\"\nvalues",
            &["study.toml:6:", "unknown key \"viscosty\"", "did you mean \"viscosity\"?"][..],
        ),
        ("contacts[0].friction", "contacts[3].friction", &["study.toml:10:", "counted from 0"][..]),
        (
            "grains.max_speed\", of = \"max\"",
            "grains.max_sped\", of = \"max\"",
            &["study.toml:17:", "no run has a signal", "did you mean \"grains.max_speed\"?"][..],
        ),
        ("of = \"max\"", "of = \"maximum\"", &["study.toml:17:", "found \"maximum\""][..]),
        ("0.08 Pa s", "50 mPa s", &["points 1 and 3 are the same run"][..]),
        ("base.toml", "bass.toml", &["study.toml:2:", "there is no file"][..]),
    ] {
        assert!(study.contains(from), "{from}");
        let home = Home::new(&study.replacen(from, to, 1));
        let output = home.study(&["--out", "out"]);
        let found = errors(&output);
        assert_eq!(output.status.code(), Some(2), "{from}: {found}");
        assert!(words.iter().all(|words| found.contains(words)), "{words:?}:\n{found}");
        assert!(!home.path().join("out").exists(), "{from}");
    }
    let home = Home::new(&study.replace("0.08 Pa s", "0.08 m"));
    let output = home.study(&["--json"]);
    let problem: serde_json::Value =
        serde_json::from_str(said(&output).lines().next().unwrap()).unwrap();
    assert_eq!((&problem["event"], &problem["line"]), (&"problem".into(), &6.into()), "{problem}");
}

/// A study may wait for days while its user goes on with the manifest.
#[test]
fn a_run_whose_manifest_changed_since_it_was_planned_is_refused() {
    let home = Home::new(STUDY);
    let printed = said(&home.study(&["--out", "out", "--print"]));
    let lines: Vec<&str> = printed.lines().collect();
    let make = |line: &str| Command::new("sh").args(["-c", line]).output().unwrap();
    assert!(make(lines[0]).status.success());
    let longer = SMALL.replace("0.02 s", "0.03 s");
    std::fs::write(home.path().join("base.toml"), longer).unwrap();
    let refused = make(lines[1]);
    assert_eq!(refused.status.code(), Some(2));
    let said = errors(&refused);
    assert!(said.contains("has changed since the study planned this run"), "{said}");
    assert_eq!(home.ended("out").len(), 1);
}

#[test]
fn printed_lines_make_the_runs_of_the_study() {
    let home = Home::new(STUDY);
    let printed = said(&home.study(&["--out", "out", "--print"]));
    assert_eq!(printed.lines().count(), 4, "{printed}");
    assert!(!home.path().join("out").exists());
    for line in printed.lines() {
        assert!(Command::new("sh").args(["-c", line]).status().unwrap().success(), "{line}");
    }
    let output = home.study(&["--out", "out"]);
    assert!(errors(&output).contains("4 of 4 runs are done, 0 made now"), "{}", errors(&output));
    assert_eq!(said(&home.study(&["--out", "out", "--print"])), "");
    let listed = said(&home.study(&["--out", "out", "--list"]));
    assert_eq!(listed.lines().count(), 5, "{listed}");
    assert_eq!(listed.matches("completed").count(), 4, "{listed}");
}

/// A broken-off run is removed by its printed line.
#[test]
fn a_printed_line_makes_a_broken_run_again() {
    let home = Home::new("base = \"base.toml\"\n");
    let first = said(&home.study(&["--out", "out", "--print"]));
    let out = first.split_whitespace().skip_while(|word| *word != "--out").nth(1).unwrap();
    std::fs::create_dir_all(out).unwrap();
    std::fs::write(Path::new(out).join("signals.csv"), "window").unwrap();
    let line = said(&home.study(&["--out", "out", "--print"]));
    assert!(line.starts_with("rm -r "), "{line}");
    assert!(Command::new("sh").args(["-c", &line]).status().unwrap().success());
    assert_eq!(home.ended("out").len(), 1);
}

#[test]
fn the_examples_are_right() {
    let output =
        tremie().args(["study", "examples/studies/sphere.toml", "--list"]).output().unwrap();
    assert!(output.status.success(), "{}", errors(&output));
    assert_eq!(said(&output).lines().count(), 9 + 1);
    let coarse = std::fs::read_dir("examples/studies/valve/coarse").unwrap();
    let coarse = coarse.map(|entry| entry.unwrap().path());
    let coarse: Vec<_> = coarse.collect();
    let lines = |option: &str| {
        let output = tremie().arg("study").args(&coarse).arg(option).output().unwrap();
        assert!(output.status.success(), "{}", errors(&output));
        said(&output).lines().count()
    };
    // A line for each study and for its heads.
    assert_eq!(lines("--list") - 2 * coarse.len(), 68);
    assert_eq!(lines("--print"), 60, "runs of several studies are made once");
}

/// The studies at the paper's resolution are of manifests that the reader makes first; else they
/// differ from the coarse ones in the sizes of the grains and in the lattice's precision alone.
#[test]
fn the_studies_of_both_resolutions_vary_the_same() {
    let table = |folder: &str, name: &std::ffi::OsStr| {
        let path = Path::new("examples/studies/valve").join(folder).join(name);
        std::fs::read_to_string(path).unwrap().parse::<toml::Table>().unwrap()
    };
    for entry in std::fs::read_dir("examples/studies/valve/coarse").unwrap() {
        let name = entry.unwrap().file_name();
        let (mut coarse, mut paper) = (table("coarse", &name), table("paper", &name));
        for study in [&mut coarse, &mut paper] {
            study.remove("base");
            let set = study["set"].as_table_mut().unwrap();
            set.remove("settings.fluid-lbm.precision");
            let name = name.to_string_lossy();
            if name.contains("diameter") || name.contains("sizes") {
                study["axes"].as_array_mut().unwrap()[0].as_table_mut().unwrap().remove("rows");
            }
        }
        assert_eq!(coarse, paper, "{}", name.display());
    }
}
