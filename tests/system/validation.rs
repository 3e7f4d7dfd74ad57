//! The short forms of the validation cases, as `tremie validate --short` runs them.

use crate::resident::family;
use crate::running::Running;
use crate::tremie::{root, tremie};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn short_forms_of_all_cases_are_within_their_tolerances() {
    let output = tremie().args(["validate", "--short", "--jobs", "2"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains("all passed"));
}

#[test]
fn a_case_that_is_not_there_is_named() {
    let output = tremie().args(["validate", "--short", "settling-spere"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    assert!(said.contains("settling-spere") && said.contains("settling-sphere"), "{said}");
}

/// A program that starts runs of its own takes them along, whoever ends it.
#[test]
fn a_validation_that_is_ended_leaves_no_run() {
    for signal in ["-INT", "-TERM", "-KILL"] {
        // A script that starts tests in the background has them ignore -INT, which a child inherits.
        let mut command = Command::new("env");
        command
            .arg("--default-signal=INT")
            .arg(tremie().get_program())
            .current_dir(root())
            .stdin(Stdio::null());
        command.args(["validate", "cylinder"]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut running = Running::start(&mut command);
        let begin = Instant::now();
        let wait = || {
            assert!(begin.elapsed() < Duration::from_secs(60), "{signal}");
            std::thread::sleep(Duration::from_millis(10));
        };
        // The run, and its component.
        while family(running.id()).len() < 3 {
            wait();
        }
        let all = family(running.id());
        running.send(signal);
        running.wait(Duration::from_secs(30));
        let is_there = |id: &u32| Path::new(&format!("/proc/{id}")).exists();
        while all.iter().any(is_there) {
            wait();
        }
    }
}

/// One sphere that falls, dry.
const FALL: &str = r#"
[run]
until = "1 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

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

const CASE: &str = r#"
title = "A fall"
source = "Galilei"

[[runs]]
name = "broken"
[runs.set]
"scene.bodies[0].density" = "-1 kg/m3"

[[runs]]
name = "whole"
[[runs.checks]]
name = "speed"
value = { signal = "grains.max_speed", take = "last" }
expected = 9.81e-3
tolerance = 1e-6

[[runs]]
name = "against the broken one"
[[runs.checks]]
name = "speed over that"
value = { signal = "grains.max_speed", take = "last" }
over = { run = "broken", signal = "grains.max_speed", take = "last" }
expected = 1.0
tolerance = 0.1
"#;

/// A run that fails takes no other's result with it.
#[test]
fn a_run_that_fails_is_told_among_the_results_of_the_others() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("cases/fall");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("manifest.toml"), FALL).unwrap();
    std::fs::write(folder.join("case.toml"), CASE).unwrap();
    let output = tremie()
        .args(["validate", "--cases", "cases", "--report", "report.md"])
        .current_dir(home.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let report = std::fs::read_to_string(home.path().join("report.md")).unwrap();
    println!("{said}{}\n{report}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(1));
    assert!(said.contains("fall, broken: the run failed") && said.contains("not all passed"));
    assert!(report.contains("| broken | the run failed") && report.contains("**a run failed**"));
    assert!(report.contains("| whole | speed | reference | 0.00981 |"), "its result is kept");
    assert!(report.contains("| against the broken one | the run failed"));
}

/// A record that is missed for a stated reason, a trend, and a check with bounds without a kind.
#[test]
fn failures_that_stand_are_told_apart() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("cases/fall");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("manifest.toml"), FALL).unwrap();
    let case = |more: &str| {
        format!(
            r#"
title = "A fall"
source = "Galilei"

[[runs]]
name = "whole"
[[runs.checks]]
name = "it falls"
kind = "trend"
value = {{ signal = "grains.body0_vz", take = "last" }}
between = [-1.0, -1e-3]
[[runs.checks]]
name = "speed"
{more}
value = {{ signal = "grains.body0_vz", take = "last" }}
between = [0.0, 1.0]
"#
        )
    };
    let validate = |more: &str| {
        std::fs::write(folder.join("case.toml"), case(more)).unwrap();
        let output = tremie()
            .args(["validate", "--cases", "cases", "--report", "report.md"])
            .current_dir(home.path())
            .output()
            .unwrap();
        let [said, errors] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.code(), said, errors)
    };
    let (code, said, errors) = validate("kind = \"record\"\nstands = \"It points upwards.\"");
    assert_eq!(code, Some(0), "{said}{errors}");
    let last = "2 checks, all passed but 1 whose failure stands: 1 of 1 trends, 0 of 1 records";
    assert!(said.contains(last), "{said}");
    let report = std::fs::read_to_string(home.path().join("report.md")).unwrap();
    assert!(report.contains("|  | 1 of 1 | **0 of 1** |"), "{report}");
    assert!(report.contains("| record | -0.00981 | 0 to 1 |  |  | **no**, stands |"), "{report}");
    assert!(report.contains("whole, speed: the failure stands. It points upwards."), "{report}");
    let (code, said, _) = validate("kind = \"record\"");
    assert_eq!((code, said.contains("2 checks, not all passed")), (Some(1), true), "{said}");
    let (code, _, errors) = validate("");
    assert_eq!(code, Some(1));
    assert!(
        errors.contains("check \"speed\": needs a kind: reference, trend or record"),
        "{errors}"
    );
}
