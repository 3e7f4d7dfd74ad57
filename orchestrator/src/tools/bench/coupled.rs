//! Benchmarks of whole runs by this very program: windows in which nothing is computed, and a
//! valve's wall time by component.

use crate::manifest;
use crate::outputs::{self, Ending, RunFolder, Summary};
use crate::run::launch::this_program;
use crate::run::{Execution, RunCall, prepare};
use crate::terminal::{Style, Terminal};
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;
use tremie_sdk::benchmark::{Benchmark, Measurement, Quantity};
use tremie_sdk::idle::WINDOW;

/// Bodies of exchanges, and windows that are done in a second, about.
const EXCHANGES: [(usize, f64); 3] = [(1, 50_000.0), (1_000, 15_000.0), (100_000, 100.0)];
/// Simulated time of the valve's runs: it is shut at first, and open most of the time.
const VALVE: &str = "4 ms";

/// Benchmarks of exchanges and of the valve.
pub fn benchmarks() -> Vec<Benchmark> {
    let mut cases = Vec::new();
    for (bodies, rate) in EXCHANGES {
        for (waiting, poll) in [("polling", None), ("blocking", Some(Duration::ZERO))] {
            cases.push(exchange(bodies, rate, waiting, poll));
        }
    }
    for (rig, in_process) in [("processes", false), ("one process", true)] {
        cases.push(valve(rig, in_process));
    }
    cases
}

/// A fluid that finds no loads and grains that never move.
fn exchange(bodies: usize, rate: f64, waiting: &str, poll: Option<Duration>) -> Benchmark {
    let make = move || {
        let measure: Measurement = Box::new(move |seconds| {
            // At least 10, so that a rate guessed too low still gives a mean.
            let windows = (rate * seconds).max(10.0) as u64;
            let summary = idle_run(bodies, windows, poll)?;
            let a_window = |seconds: f64| 1e6 * seconds / summary.windows as f64;
            let wait = summary.components.values().map(|c| c.wait).fold(0.0, f64::max);
            Ok(vec![a_window(summary.wall_time), a_window(wait)])
        });
        Ok(measure)
    };
    let quantities =
        vec![Quantity::new("a window", "us"), Quantity::new("the longest wait in it", "us")];
    let some = if bodies == 1 { "1 body".into() } else { format!("{bodies} bodies") };
    let name = format!("exchange of {some}, {waiting}, 3 processes");
    Benchmark { name, threads: 0, quantities, make: Box::new(make) }
}

fn idle_run(bodies: usize, windows: u64, poll: Option<Duration>) -> Result<Summary, String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let folder = tempfile::tempdir().map_err(|error| text(&error))?;
    let path = folder.path();
    let manifest =
        manifest::parse(&path.join("manifest.toml"), idle_manifest(bodies, windows), &[])
            .map_err(|errors| text(&errors))?;
    let execution = Execution { poll, ..Execution::default() };
    let nobody = AtomicUsize::new(0);
    let prepared = prepare(&manifest, path, path, &execution, &nobody);
    let prepared = prepared.map_err(|error| text(&error))?;
    let mut terminal = Terminal::new(Style::Silent);
    let mut out = RunFolder::claim(path).map_err(|error| text(&error))?;
    let ended = prepared.execute(RunCall {
        manifest: &manifest,
        out: &mut out,
        execution: &execution,
        terminal: &mut terminal,
        interrupts: &nobody,
        programs: path,
        from: None,
    });
    let summary = ended.map_err(|error| text(&error))?.close();
    match summary.ending {
        Ending::Completed => Ok(summary),
        other => Err(format!("the run without work ended otherwise than well: {other:?}")),
    }
}

fn idle_manifest(bodies: usize, windows: u64) -> String {
    let until = WINDOW * windows as f64;
    format!(
        r#"
        [run]
        until = "{until} s"

        [scene.domain]
        size = ["10 mm", "10 mm", "10 mm"]

        [scene.fluid]
        density = "1000 kg/m3"
        viscosity = "1 Pa s"

        [components]
        fluid = "idle-fluid"
        grains = "idle-grains"

        [settings.idle-grains]
        bodies = {bodies}

        [outputs]
        record = false
        "#
    )
}

/// The coarse valve with its rubber ring, as `tremie scene` makes it.
fn valve(rig: &str, in_process: bool) -> Benchmark {
    let make = move || {
        let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
        let scene = folder.path().join("valve");
        own(&["scene", "pressure-valve", &scene.to_string_lossy(), "--coarse"])?;
        let mut count = 0;
        let measure: Measurement = Box::new(move |_| {
            count += 1;
            let out = folder.path().join(format!("out-{count}"));
            let (scene, out_text) = (scene.to_string_lossy(), out.to_string_lossy());
            let mut command = vec!["run", &scene, "--out", &out_text, "--until", VALVE, "--quiet"];
            command.extend(["--set", "outputs.record=false"]);
            command.extend(in_process.then_some("--in-process"));
            own(&command)?;
            read(&out.join(outputs::SUMMARY))
        });
        Ok(measure)
    };
    let quantities = vec![
        Quantity::new("windows", "1/s"),
        Quantity::new("fluid computes", "us a window"),
        Quantity::new("grains compute", "us a window"),
        Quantity::new("rubber computes", "us a window"),
        Quantity::new("none computes", "us a window"),
    ];
    let name = format!("coupled, coarse valve with a rubber ring in {rig}");
    Benchmark { name, threads: 0, quantities, make: Box::new(make) }
}

/// Calls this program.
fn own(arguments: &[&str]) -> Result<(), String> {
    let mut command = this_program();
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null());
    let told = command.output().map_err(|error| error.to_string())?;
    let said = String::from_utf8_lossy(&told.stderr);
    if told.status.success() { Ok(()) } else { Err(said.trim().to_string()) }
}

fn read(path: &Path) -> Result<Vec<f64>, String> {
    let text = std::fs::read_to_string(path).map_err(|error| error.to_string())?;
    let summary: serde_json::Value =
        serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or(f64::NAN);
    let (windows, wall) = (number(&summary["windows"]), number(&summary["wall_time"]));
    let computing = |name: &str| 1e6 * number(&summary["components"][name]["compute"]) / windows;
    let each = ["fluid", "grains", "rubber"].map(computing);
    // In the serial schedule the three take turns: the rest is exchange and waiting.
    let rest = 1e6 * wall / windows - each.iter().sum::<f64>();
    Ok([&[windows / wall][..], &each, &[rest]].concat())
}
