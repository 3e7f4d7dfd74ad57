//! Ends of runs: by the plan, by a condition, by the user, and after a kill.

use crate::running::{Running, children_of, is_alive, until};
use crate::tremie::{Ran, SMALL, run_text, tremie};
use std::collections::HashMap;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tremie_recorder::{Item, Recording};

#[test]
fn a_run_ends_in_time_with_all_outputs() {
    let ran = run_text(SMALL, &[]).succeeded();
    for file in ["manifest.toml", "scene.json", "summary.json", "signals.csv", "log.jsonl"] {
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

/// Windows of the last frames in a recording, one for each kind of frame.
fn last_frames(out: &Path) -> Vec<u64> {
    let mut items = Recording::open(&out.join("run.mcap")).unwrap().items();
    let mut last = HashMap::new();
    for item in items.by_ref().map(Result::unwrap) {
        if !matches!(item, Item::Log { .. }) {
            last.insert(std::mem::discriminant(&item), item.window());
        }
    }
    assert!(items.end().complete);
    last.into_values().collect()
}

#[test]
fn a_recording_holds_the_last_window_however_the_run_ends() {
    let recorded = SMALL.replace("record = false", "frames = \"3 ms\"");
    let stopping = "[[stop_when]]\nsignal = \"grains.max_speed\"\nabove = 0.01\n";
    let [planned, stopped, again] = [
        run_text(&recorded, &[]).succeeded(),
        run_text(&format!("{recorded}\n{stopping}"), &["--until", "1 s"]).succeeded(),
        run_text(&format!("{recorded}\n{stopping}"), &["--until", "1 s"]).succeeded(),
    ];
    for ran in [&planned, &stopped] {
        let window = ran.summary()["windows"].as_u64().unwrap();
        assert_eq!(last_frames(&ran.out), [window; 4], "{}", ran.errors());
    }
    let file = |ran: &Ran| std::fs::read(ran.out.join("run.mcap")).unwrap();
    assert!(file(&stopped) == file(&again), "two recordings of one run differ");
}

/// A run long enough to be disturbed; returns once windows are done.
fn long_run(home: &Path) -> Running {
    let manifest = home.join("manifest.toml");
    std::fs::write(
        &manifest,
        SMALL
            .replace("until = \"0.02 s\"", "until = \"100 s\"")
            .replace("record = false", "frames = \"1 s\""),
    )
    .unwrap();
    let mut command = tremie();
    command.args(["run", "--json", "--out"]).arg(home.join("out")).arg(&manifest);
    let mut running = Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()));
    running.says("\"progress\"");
    running
}

#[test]
fn ctrl_c_ends_a_run_with_whole_outputs() {
    let home = tempfile::tempdir().unwrap();
    let mut child = long_run(home.path());
    child.send("-INT");
    assert_eq!(child.wait(Duration::from_secs(10)), Some(130));
    let summary = std::fs::read_to_string(home.path().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "interrupted");
    let table = std::fs::read_to_string(home.path().join("out/signals.csv")).unwrap();
    let last: u64 =
        table.trim().lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert_eq!(Some(last), summary["windows"].as_u64());
    assert_eq!(last_frames(&home.path().join("out")), [last; 4]);
}

#[test]
fn a_killed_orchestrator_takes_its_components_along() {
    let home = tempfile::tempdir().unwrap();
    let mut child = long_run(home.path());
    let components = children_of(child.id());
    assert!(components.len() >= 2, "{components:?}");
    child.send("-KILL");
    child.wait(Duration::from_secs(5));
    until("components end", || !components.iter().any(|id| is_alive(*id)));
    let cleaned = tremie().arg("clean").output().unwrap();
    assert!(cleaned.status.success());
}
