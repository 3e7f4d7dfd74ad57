//! How runs end: by the plan, by a condition, by the user, and after a kill.

use crate::tremie::{SMALL, run_text, tremie};
use std::io::{BufRead, BufReader};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_run_ends_in_time_with_all_outputs() {
    let ran = run_text(SMALL, &[]).succeeded();
    for file in ["manifest.toml", "summary.json", "signals.csv", "log.jsonl"] {
        assert!(ran.out.join(file).exists(), "{file}");
    }
    let summary = ran.summary();
    assert_eq!(summary["status"], "completed");
    assert_eq!(summary["windows"], summary["planned_windows"]);
    let time = summary["simulated_time"].as_f64().unwrap();
    assert!((0.02..0.0205).contains(&time), "{time}");
    assert!(
        ran.errors().trim().lines().last().unwrap().starts_with("completed"),
        "{}",
        ran.errors()
    );
}

#[test]
fn the_resolved_manifest_runs_to_the_same_bits() {
    let ran = run_text(SMALL, &["--until", "5 ms"]).succeeded();
    let resolved = std::fs::read_to_string(ran.out.join("manifest.toml")).unwrap();
    let again = run_text(&resolved, &[]).succeeded();
    assert_eq!(ran.signals_text(), again.signals_text());
}

#[test]
fn a_condition_ends_a_run_at_the_same_window_every_time() {
    let text = format!("{SMALL}\n[[stop_when]]\nsignal = \"grains.max_speed\"\nabove = 0.01\n")
        .replace("until = \"0.02 s\"", "until = \"1 s\"");
    let [first, second] =
        [run_text(&text, &[]).succeeded(), run_text(&text, &["--in-process"]).succeeded()];
    assert_eq!(first.summary()["status"], "stopped");
    assert!(first.errors().contains("grains.max_speed"), "{}", first.errors());
    assert_eq!(first.summary()["windows"], second.summary()["windows"]);
    assert_eq!(first.signals_text(), second.signals_text());
}

/// A running program that is killed if the test fails before it ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A run long enough to be disturbed; returns once windows go by.
fn long_run(home: &std::path::Path) -> Running {
    let manifest = home.join("manifest.toml");
    std::fs::write(&manifest, SMALL.replace("until = \"0.02 s\"", "until = \"100 s\"")).unwrap();
    let child = tremie()
        .args(["run", "--json", "--out"])
        .arg(home.join("out"))
        .arg(&manifest)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = Running(child.unwrap());
    let lines = BufReader::new(child.0.stdout.take().unwrap()).lines();
    for line in lines.map_while(Result::ok) {
        if line.contains("\"progress\"") {
            return child;
        }
    }
    panic!("the run ended by itself");
}

fn send(child: &Running, signal: &str) {
    let id = child.0.id().to_string();
    assert!(std::process::Command::new("kill").args([signal, &id]).status().unwrap().success());
}

fn wait(child: &mut Running, limit: Duration) -> Option<i32> {
    let begin = Instant::now();
    while begin.elapsed() < limit {
        if let Some(status) = child.0.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("the run did not end within {limit:?}");
}

#[test]
fn ctrl_c_ends_a_run_with_whole_outputs() {
    let home = tempfile::tempdir().unwrap();
    let mut child = long_run(home.path());
    send(&child, "-INT");
    assert_eq!(wait(&mut child, Duration::from_secs(10)), Some(130));
    let summary = std::fs::read_to_string(home.path().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "interrupted");
    let table = std::fs::read_to_string(home.path().join("out/signals.csv")).unwrap();
    let last: u64 =
        table.trim().lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert_eq!(Some(last), summary["windows"].as_u64());
}

#[test]
fn a_killed_orchestrator_takes_its_components_along() {
    let home = tempfile::tempdir().unwrap();
    let mut child = long_run(home.path());
    let components = children_of(child.0.id());
    assert!(components.len() >= 2, "{components:?}");
    send(&child, "-KILL");
    child.0.wait().unwrap();
    let begin = Instant::now();
    while components.iter().any(|id| is_alive(*id)) {
        assert!(begin.elapsed() < Duration::from_secs(5), "components outlive the orchestrator");
        std::thread::sleep(Duration::from_millis(10));
    }
    let cleaned = tremie().arg("clean").output().unwrap();
    assert!(cleaned.status.success());
}

fn children_of(id: u32) -> Vec<u32> {
    let tasks = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap();
    tasks.split_whitespace().map(|id| id.parse().unwrap()).collect()
}

fn is_alive(id: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    // A zombie has ended; somebody only has to collect it.
    !status.is_empty() && !status.contains(") Z ")
}
