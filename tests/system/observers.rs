//! Observers: their outputs, and that they never disturb a run.

use crate::running::{Running, children_of, now, send, until};
use crate::tremie::{SMALL, left_nothing, run, run_text, tremie};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;
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

/// `examples/minimal-observer` sees every frame: the start, those in between, and the last window.
#[test]
fn an_observer_of_ones_own_sees_every_frame() {
    let observer = "[components]\nspeeds = { program = \"minimal-observer\", role = \"observer\", lossless = true }";
    let manifest = SMALL.replacen("[components]", observer, 1);
    let ran = run_text(&manifest, &["--set", "outputs.frames=\"2 ms\""]).succeeded();
    let text = std::fs::read_to_string(ran.out.join("speeds.csv")).unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|number| number.parse().unwrap()).collect())
        .collect();
    assert!((10..=12).contains(&rows.len()), "{text}");
    // The grains start at rest and fall.
    assert_eq!((rows[0][0], rows[0][2]), (0.0, 0.0));
    assert!(rows[1..].iter().all(|row| row[2] > 0.0), "{text}");
    let last = *ran.signals()["time"].last().unwrap();
    assert!((rows.last().unwrap()[1] - last).abs() < 1e-12, "{text}");
}

/// The process that is the component `name` of an orchestrator.
fn component(orchestrator: u32, name: &str) -> Option<u32> {
    children_of(orchestrator).into_iter().find(|id| {
        let line = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
        // Not the orchestrator's own line, which a child bears until it becomes the component.
        line.contains(&format!("component\0{name}\0"))
    })
}

/// A run of the small scene in `home`, with `arguments`, that reports its progress.
fn observed_run(home: &Path, arguments: &[&str]) -> Running {
    let manifest = home.join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let mut command = tremie();
    command.args(["run", "--json", "--out"]).arg(home.join("out")).arg(&manifest).args(arguments);
    Running::start(command.stdout(Stdio::piped()).stderr(Stdio::piped()))
}

fn summary(home: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(home.join("out/summary.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Rows of a table of signals by window.
fn rows(table: &str) -> BTreeMap<u64, String> {
    let row = |line: &str| (line.split(',').next().unwrap().parse().unwrap(), line.to_string());
    table.lines().skip(1).map(row).collect()
}

#[test]
fn a_stopped_viewer_stops_nothing_and_changes_nothing() {
    let every = ["--set", "outputs.signals=1 ms"];
    let alone = rows(&run_text(SMALL, &every).succeeded().signals_text());
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("run.rrd");
    // Lossy, as it is by default; without an end, so that the viewer is stopped in mid-run for
    // sure.
    let view = ["--until", "100 s", "--set", "outputs.frames=1 ms", "--view"];
    let mut running =
        observed_run(home.path(), &[&every[..], &view, &[file.to_str().unwrap()]].concat());
    running.says("\"progress\"");
    send(component(running.id(), "viewer").unwrap(), "-STOP");
    let time = |line: String| -> f64 {
        serde_json::from_str::<serde_json::Value>(&line).unwrap()["time"].as_f64().unwrap()
    };
    let stopped_at = time(running.says("\"progress\""));
    while time(running.says("\"progress\"")) < stopped_at.max(0.02) {}
    running.send("-INT");
    assert_eq!(running.wait(Duration::from_secs(60)), Some(130));
    let observers = &summary(home.path())["observers"];
    assert!(observers["viewer"].as_str().unwrap().starts_with("lost"), "{observers}");
    let watched = rows(&std::fs::read_to_string(home.path().join("out/signals.csv")).unwrap());
    let both: Vec<_> = alone.keys().filter(|window| watched.contains_key(window)).collect();
    assert!(both.len() > 10, "{both:?}");
    for window in both {
        assert_eq!(alone[window], watched[window]);
    }
}

#[test]
fn a_stopped_recorder_is_given_up_in_time_and_changes_nothing() {
    // Long enough to be stopped in the middle; a recorder that is only slow has a share of 8 s.
    let window = ["--until", "0.4 s", "--set", "run.deadline=8 s"];
    let alone = run_text(SMALL, &window).succeeded().signals_text();
    let home = tempfile::tempdir().unwrap();
    let record = ["--set", "outputs.record=true", "--set", "outputs.frames=1 us"];
    let mut running = observed_run(home.path(), &[&window[..], &record].concat());
    // A frame of each window, of which the physics can send only a few more than the recorder
    // takes.
    let file = home.path().join("out/run.mcap");
    let size = || std::fs::metadata(&file).map_or(0, |data| data.len());
    until("the recorder writes windows", || size() > 100_000);
    let recorder = component(running.id(), "recorder").unwrap();
    send(recorder, "-STOP");
    let warning = running.says("recorder is lost");
    assert!(warning.contains("the run goes on"), "{warning}");
    assert_eq!(running.wait(Duration::from_secs(60)), Some(0));
    let ended = now();
    let summary = summary(home.path());
    assert_eq!(summary["status"], "completed");
    assert!(summary["observers"]["recorder"].as_str().unwrap().starts_with("lost"), "{summary}");
    let watched = std::fs::read_to_string(home.path().join("out/signals.csv")).unwrap();
    assert!(watched == alone, "the recorder changed the run");
    left_nothing(&summary, ended, "");
}

/// The recording goes to a pipe, which takes 64 KiB and then nothing until somebody reads on: longer than the physics
/// would wait for a recorder that takes no frames, and longer than an observer may say nothing at the end.
#[test]
fn a_disk_that_stands_still_loses_nothing() {
    let window = ["--until", "0.4 s", "--set", "run.deadline=8 s", "--set", "outputs.frames=1 us"];
    let window = [&window[..], &["--set", "outputs.record=true"]].concat();
    let whole = run_text(SMALL, &[&window[..], &["--quiet"]].concat()).succeeded();
    let whole = std::fs::read(whole.out.join("run.mcap")).unwrap();
    assert!(whole.len() > 1 << 20, "{} bytes fit into the pipe", whole.len());

    let home = tempfile::tempdir().unwrap();
    let pipe = home.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let file = format!("settings.recorder.file={pipe:?}");
    let (goes_on, wait) = channel::<()>();
    let reader = std::thread::spawn(move || {
        let mut reader = File::open(pipe).unwrap();
        let mut bytes = vec![0; 100_000];
        reader.read_exact(&mut bytes).unwrap();
        wait.recv().unwrap();
        reader.read_to_end(&mut bytes).unwrap();
        bytes
    });
    let mut running = observed_run(home.path(), &[&window[..], &["--set", &file]].concat());
    running.says("waiting for files of recorder");
    std::thread::sleep(Duration::from_secs(4));
    goes_on.send(()).unwrap();
    assert_eq!(running.wait(Duration::from_secs(60)), Some(0));
    let observers = &summary(home.path())["observers"];
    assert!(!observers["recorder"].as_str().unwrap().starts_with("lost"), "{observers}");
    let piped = reader.join().unwrap();
    assert!(piped == whole, "{} bytes, expected {}", piped.len(), whole.len());
}
