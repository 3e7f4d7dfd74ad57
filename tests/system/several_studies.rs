//! Several studies in one command: they share the queue, and the runs that more than one of them has.

use crate::running::{Running, until};
use crate::study::{Home, STUDY, WITH_CHECKPOINTS, errors, said};
use crate::tremie::{SMALL, tremie};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Three studies: `thin` and `thick` have the run with 0.08 Pa s both, `all` that and the one with 0.1 Pa s.
fn home_of_three() -> Home {
    let home = Home::new("");
    let study = STUDY.replace(", [0.1, 0.9]]", "]");
    for (name, values) in [
        ("thin", r#""0.05 Pa s", "1e-12 Pa s", "0.08 Pa s""#),
        ("thick", r#""0.08 Pa s", "0.1 Pa s""#),
        ("all", r#""0.1 Pa s", "0.08 Pa s", "0.09 Pa s""#),
    ] {
        let text = study.replace(r#""0.05 Pa s", "0.08 Pa s""#, values);
        std::fs::write(home.path().join(format!("{name}.toml")), text).unwrap();
    }
    home
}

/// Two studies of one longer run, that are the same.
fn home_of_twins() -> Home {
    let home = Home::new("");
    for name in ["one", "two"] {
        std::fs::write(home.path().join(format!("{name}.toml")), WITH_CHECKPOINTS).unwrap();
    }
    home
}

fn studies(home: &Home, words: &[&str]) -> Command {
    let mut command = tremie();
    command.current_dir(home.path()).arg("study").args(words);
    command
}

fn made(home: &Home, words: &[&str]) -> Output {
    studies(home, words).output().unwrap()
}

/// All files within a folder, by their paths in it.
fn files(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        match path.is_dir() {
            true => {
                all.extend(files(&path).into_iter().map(|(rest, bytes)| (name.join(rest), bytes)))
            }
            false => all.push((name, std::fs::read(&path).unwrap())),
        }
    }
    all.sort();
    all
}

/// Folder of the only run of a study.
fn run_of(home: &Home, study: &str) -> PathBuf {
    let runs = std::fs::read_dir(home.path().join("studies").join(study).join("runs"));
    runs.unwrap().next().unwrap().unwrap().path()
}

/// The tables are those of each study alone.
#[test]
fn a_run_of_several_studies_is_made_once() {
    let home = home_of_three();
    assert_eq!(made(&home, &["thin.toml", "--out", "alone/thin"]).status.code(), Some(1));
    for name in ["thick", "all"] {
        let out = format!("alone/{name}");
        assert!(made(&home, &[&format!("{name}.toml"), "--out", &out]).status.success());
    }
    let together = ["thin.toml", "thick.toml", "all.toml", "--out", "both", "--jobs", "2"];
    let output = made(&home, &together);
    let words = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{words}");
    let failure = "run 2 of 3 of thin failed: scene.fluid.viscosity = 1e-12 Pa s";
    assert!(words.contains(failure), "{words}");
    for line in [
        "2 of 3 runs are done, 3 made now, 1 failed; the table is both/thin/runs.csv",
        "2 of 2 runs are done, 1 made now; the table is both/thick/runs.csv",
        "3 of 3 runs are done, 1 made now; the table is both/all/runs.csv",
        "7 of 8 runs of 3 studies are done, 5 made now, 1 failed\n\
         `tremie study thin.toml thick.toml all.toml --out both --jobs 2` makes the failed ones again",
    ] {
        assert!(words.contains(line), "{line}\n{words}");
    }
    for name in ["thin", "thick", "all"] {
        for table in ["runs.csv", "runs.parquet", "speed-over-scene-fluid-viscosity.svg"] {
            let of =
                |all: &str| std::fs::read(home.path().join(all).join(name).join(table)).unwrap();
            assert!(of("both") == of("alone"), "{name}: {table}");
        }
    }

    // A run that is done comes from any study that has it.
    for name in ["thin", "all"] {
        std::fs::remove_dir_all(home.path().join("both").join(name)).unwrap();
    }
    let words = errors(&made(&home, &together));
    assert!(words.contains("7 of 8 runs of 3 studies are done, 3 made now, 1 failed"), "{words}");
    for name in ["thin", "all"] {
        let of = |all: &str| home.table(&format!("{all}/{name}"), "runs.csv");
        assert_eq!(of("both"), of("alone"), "{name}");
    }
}

/// It stops by its Mach number in both: it is tried and told once, and a run that is done stays.
#[test]
fn a_run_of_several_studies_that_fails_is_tried_once() {
    let home = Home::new("");
    let study = STUDY.replace(", [0.1, 0.9]]", "]").replace("scene.fluid.viscosity", "watch.mach");
    for (name, values) in [("low", "0.16, 1e-6"), ("high", "0.15, 1e-6")] {
        let text = study.replace(r#""0.05 Pa s", "0.08 Pa s""#, values);
        std::fs::write(home.path().join(format!("{name}.toml")), text).unwrap();
    }
    let output = made(&home, &["low.toml", "high.toml", "--json"]);
    assert_eq!(output.status.code(), Some(1), "{}", errors(&output));
    let events: Vec<Value> =
        said(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &str| events.iter().filter(|event| event["event"] == kind).count();
    assert_eq!((of("run"), of("failure")), (4, 1), "{events:?}");
    let words = errors(&made(&home, &["low.toml", "high.toml"]));
    assert!(
        words.contains("run 2 of 2 of low failed, also in high: watch.mach = 0.000001"),
        "{words}"
    );
    let end = &events.iter().find(|event| event["event"] == "end").unwrap()["summary"];
    let [low, high] = [("low", 2), ("high", 1)].map(|(name, made)| {
        let table = format!("studies/{name}/runs.csv");
        json!({"table": table, "runs": 2, "done": 1, "made": made, "failed": 1})
    });
    assert_eq!(end, &json!({"runs": 4, "done": 2, "made": 3, "failed": 2, "studies": [low, high]}));
    for name in ["low", "high"] {
        let table = home.table(&format!("studies/{name}"), "runs.csv");
        assert_eq!(table.matches(",failed,").count(), 1, "{table}");
    }
    let runs = |name: &str| {
        std::fs::read_dir(home.path().join("studies").join(name).join("runs")).unwrap().count()
    };
    assert_eq!((runs("low"), runs("high")), (2, 1), "a failed run is copied");
}

/// A run goes on where it was broken off, and is copied with all its files.
#[test]
fn a_run_of_several_studies_goes_on_where_one_left_it() {
    let home = home_of_twins();
    let mut command = studies(&home, &["two.toml"]);
    let mut running = Running::start(command.stdout(Stdio::null()).stderr(Stdio::null()));
    until("a checkpoint", || !home.checkpoints("studies/two").is_empty());
    running.send("-KILL");
    running.wait(Duration::from_secs(60));
    until("the run's end", || !home.ended("studies/two").is_empty());
    // What a kill left of a copy.
    std::fs::create_dir_all(home.path().join("studies/one/copy.part/checkpoints")).unwrap();
    let output = made(&home, &["one.toml", "two.toml"]);
    let words = errors(&output);
    assert!(output.status.success(), "{words}");
    assert!(words.contains("2 of 2 runs of 2 studies are done, 1 made now"), "{words}");
    let [one, two] = ["one", "two"].map(|name| run_of(&home, name));
    assert_eq!(files(&one), files(&two));
    assert!(files(&one).iter().any(|(path, _)| path.starts_with("checkpoints")));
    let log = std::fs::read_to_string(one.join("log.jsonl")).unwrap();
    assert!(log.contains("the run goes on from"), "{log}");
    assert!(!home.path().join("studies/one/copy.part").exists());
}

/// A run that somebody else is making, here by a printed line, is waited for.
#[test]
fn a_run_of_several_studies_that_is_under_way_is_waited_for() {
    let home = home_of_twins();
    let line = said(&made(&home, &["two.toml", "--print"]));
    let line = format!("exec {}", line.trim_end());
    let mut command = Command::new("sh");
    let command = command.args(["-c", &line]).stdout(Stdio::null()).stderr(Stdio::null());
    let mut other = Running::start(command);
    let runs = home.path().join("studies/two/runs");
    let has_table = |run: std::fs::DirEntry| run.path().join("signals.csv").exists();
    until("a run", || std::fs::read_dir(&runs).is_ok_and(|runs| runs.flatten().any(has_table)));
    assert!(home.ended("studies/two").is_empty(), "the run has ended too early");
    let output = made(&home, &["one.toml", "two.toml"]);
    let words = errors(&output);
    assert!(output.status.success(), "{words}");
    assert!(words.contains("2 of 2 runs of 2 studies are done, 0 made now"), "{words}");
    assert_eq!(other.wait(Duration::from_secs(60)), Some(0));
    assert_eq!(home.table("studies/one", "runs.csv"), home.table("studies/two", "runs.csv"));
}

/// A copy that the disk refuses costs a run, not the studies.
#[test]
fn a_run_that_cannot_be_copied_is_made() {
    let home = home_of_twins();
    assert!(made(&home, &["two.toml"]).status.success());
    // A link to nowhere cannot be copied.
    let link = run_of(&home, "two").join("nowhere");
    std::os::unix::fs::symlink("/nowhere/at/all", link).unwrap();
    let output = made(&home, &["one.toml", "two.toml"]);
    let words = errors(&output);
    assert!(output.status.success(), "{words}");
    assert!(words.contains("is made anew"), "{words}");
    assert!(words.contains("2 of 2 runs of 2 studies are done, 1 made now"), "{words}");
    assert_eq!(home.table("studies/one", "runs.csv"), home.table("studies/two", "runs.csv"));
}

/// Manifests in two folders find other programs: their runs are not the same.
#[test]
fn studies_of_manifests_in_other_folders_share_no_run() {
    let home = Home::new("");
    for name in ["one", "two"] {
        let folder = home.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("base.toml"), SMALL).unwrap();
        std::fs::write(folder.join(format!("{name}.toml")), "base = \"base.toml\"\n").unwrap();
    }
    let words = errors(&made(&home, &["one/one.toml", "two/two.toml"]));
    assert!(words.contains("2 of 2 runs of 2 studies are done, 2 made now"), "{words}");
}

fn words_of_one(home: &Home) -> String {
    errors(&made(home, &["thin.toml"]))
}

#[test]
fn several_studies_are_checked_listed_and_printed_together() {
    let home = home_of_three();
    let both = ["thin.toml", "thick.toml"];
    let listed = made(&home, &[both[0], both[1], "--list"]);
    assert!(listed.status.success(), "{}", errors(&listed));
    let listed = said(&listed);
    assert!(listed.contains("3 points, 3 runs; outputs in studies/thin\n"), "{listed}");
    assert_eq!(listed.lines().count(), 2 + 2 + 3 + 2, "{listed}");
    let printed = said(&made(&home, &[both[0], both[1], "--print"]));
    assert_eq!(printed.lines().count(), 4, "the run of both once: {printed}");

    let output = made(&home, &["thin.toml", "thin.toml"]);
    assert_eq!(output.status.code(), Some(1));
    let words = "two study files would have the folder studies/thin; give each";
    assert!(errors(&output).contains(words), "{}", errors(&output));
    // What is wrong with a manifest is told once, what is wrong with a study for each; nothing runs.
    let base = home.path().join("base.toml");
    std::fs::write(&base, SMALL.replace("until = ", "untill = ")).unwrap();
    let words = errors(&made(&home, &both));
    assert_eq!(words.matches("untill").count(), words_of_one(&home).matches("untill").count());
    std::fs::write(base, SMALL).unwrap();
    for name in both {
        let file = home.path().join(name);
        let wrong = std::fs::read_to_string(&file).unwrap().replace("\"max\"", "\"most\"");
        std::fs::write(file, wrong).unwrap();
    }
    let output = made(&home, &both);
    assert_eq!(output.status.code(), Some(2));
    let words = errors(&output);
    assert!(words.contains("thin.toml:17:") && words.contains("thick.toml:17:"), "{words}");
    assert!(!home.path().join("studies").exists());
}
