//! Observers: what they leave, and that they never disturb a run.

use crate::running::{Running, children_of, send};
use crate::tremie::{SMALL, run, run_text, tremie};
use std::process::{Command, Stdio};
use std::time::Duration;

#[test]
fn a_recording_for_later_is_written_by_the_viewer() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("run.rrd");
    let ran = run_text(SMALL, &["--view", file.to_str().unwrap()]).succeeded();
    let bytes = std::fs::read(&file).unwrap();
    assert!(bytes.starts_with(b"RRF"), "{}", ran.errors());
}

#[test]
fn a_finished_run_can_be_viewed() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("run.rrd");
    let ran = run("examples/settling-sphere/short.toml", &["--until", "20 ms"]).succeeded();
    let output = tremie().arg("view").arg(&ran.out).arg("--view").arg(&file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(std::fs::read(&file).unwrap().starts_with(b"RRF"));
}

#[test]
fn a_viewer_that_dies_after_the_run_is_not_waited_for() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let mut command = tremie();
    command.args([
        "run",
        "--json",
        "--view",
        "web",
        "--set",
        "settings.viewer.open=false",
        "--out",
    ]);
    command.arg(home.path().join("out")).arg(&manifest).stdout(Stdio::piped());
    let mut running = Running::start(&mut command);
    running.says("the viewer stays up");
    let viewer = component(running.id(), "viewer").unwrap();
    send(viewer, "-KILL");
    running.says("the viewer has ended by itself");
    assert_eq!(running.wait(Duration::from_secs(10)), Some(0));
}

/// The process that is the component `name` of an orchestrator.
fn component(orchestrator: u32, name: &str) -> Option<u32> {
    children_of(orchestrator).into_iter().find(|id| {
        let line = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
        // Not the orchestrator's own line, which a child bears until it becomes the component.
        line.contains(&format!("component\0{name}\0"))
    })
}

#[test]
fn a_stopped_viewer_stops_nothing_and_changes_nothing() {
    let alone = run_text(SMALL, &[]).succeeded().signals_text();
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let out = home.path().join("out");
    let file = home.path().join("run.rrd");
    let child = tremie()
        .arg("run")
        .arg(&manifest)
        .arg("--out")
        .arg(&out)
        .args([
            "--set",
            "components.viewer={ program = \"viewer\", role = \"observer\", lossless = false }",
        ])
        .args(["--set", "outputs.frames=1 ms", "--view"])
        .arg(&file)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    stop_viewer_of(child.id());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(out.join("signals.csv")).unwrap(), alone);
}

/// Sends SIGSTOP to the component `viewer` of an orchestrator, as soon as there is one.
fn stop_viewer_of(orchestrator: u32) {
    for _ in 0..1000 {
        let path = format!("/proc/{orchestrator}/task/{orchestrator}/children");
        for id in std::fs::read_to_string(path).unwrap_or_default().split_whitespace() {
            let line = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
            // Not the orchestrator's own line, which a child bears until it becomes the component.
            if line.contains("component\0viewer\0") {
                // Past its start, so that the run has begun.
                std::thread::sleep(Duration::from_millis(300));
                let _ = Command::new("kill").args(["-STOP", id]).status();
                return;
            }
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("no viewer was started");
}
