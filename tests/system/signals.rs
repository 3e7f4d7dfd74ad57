//! What a run reports, and what that means.

use crate::inlets::STREAM;
use crate::tremie::{Ran, SMALL, run_text, tremie};
use serde_json::Value;

/// The signals of a manifest, as `tremie signals --json` lists them.
fn signals(manifest: &str) -> Vec<Value> {
    let output = tremie().args(["signals", "--json", manifest]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    let event: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    assert_eq!(event["event"], "signals");
    event["signals"].as_array().unwrap().clone()
}

#[test]
fn every_signal_of_the_built_in_components_is_explained() {
    let home = tempfile::tempdir().unwrap();
    let stream = home.path().join("manifest.toml");
    std::fs::write(&stream, STREAM).unwrap();
    for manifest in [
        "examples/pressure-valve",
        "examples/pressure-valve/grains.toml",
        "examples/flanged-line",
        "examples/settling-sphere",
        stream.to_str().unwrap(),
    ] {
        let all = signals(manifest);
        assert!(all.len() > 30, "{manifest}");
        for signal in all {
            assert!(!signal["meaning"].as_str().unwrap().is_empty(), "{manifest}: {signal}");
            assert!(!signal["unit"].as_str().unwrap().is_empty(), "{manifest}: {signal}");
        }
    }
}

#[test]
fn a_person_reads_a_list_and_finds_it_in_the_summary() {
    let output = tremie().args(["signals", "examples/pressure-valve"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let line = said.lines().find(|line| line.contains("rubber.ring.compression")).unwrap();
    assert!(line.contains(" m ") && line.ends_with("how far it is compressed"), "{line}");
    let ran = run_text(STREAM, &["--until", "0.5 ms", "--set", "outputs.record=false"]).succeeded();
    let told = &ran.summary()["signals"]["grains.bodies"];
    assert_eq!(told["meaning"], "grains that are there", "{told:#}");
}

/// A probe is measured where a row is kept and in the last window, with the same bits as if in every window, whoever
/// looks; extremes and conditions see what was measured.
#[test]
fn probes_are_measured_where_rows_are_kept() {
    let probe = "[[scene.probes]]\nname = \"middle\"\nregion = { min = [\"3 mm\", \"3 mm\", \"3 mm\"], max = [\"9 mm\", \"9 mm\", \"9 mm\"] }\n";
    let until =
        "[[stop_when]]\nsignal = \"fluid.middle.velocity_z\"\nbelow = -1e-4\nhold = \"4 ms\"\n";
    let text = format!("{SMALL}\n{probe}\n{until}");
    let kept = |signals: &str, outputs: &str| {
        let outputs = format!("{outputs}\nsignals = \"{signals}\"");
        run_text(&text.replace("record = false", &outputs), &["--until", "1 s"]).succeeded()
    };
    let rows = |ran: &Ran| ran.signals_text().lines().map(str::to_string).collect::<Vec<_>>();
    let all = kept("1 ns", "record = false");
    let few = kept("3 ms", "record = false");
    let watched = kept("3 ms", "frames = \"1 ms\"");
    assert_eq!(rows(&few), rows(&watched));
    let ends = |ran: &Ran| ran.summary()["windows"].as_u64().unwrap();
    assert!(ends(&few) >= ends(&all), "{} {}", ends(&few), ends(&all));

    let every = rows(&few)[2].split(',').next().unwrap().parse::<u64>().unwrap();
    assert!(every > 1 && !ends(&few).is_multiple_of(every), "{every} {}", ends(&few));
    let (all, known) = (rows(&all), rows(&few));
    let same = known.iter().filter(|row| all.contains(row)).count();
    assert!(same >= all.len() / every as usize, "{same} of {}", known.len());
    let column = &few.signals()["fluid.middle.velocity_z"];
    assert!(column.iter().all(|value| value.is_finite()), "{column:?}");
    let least = column.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(few.summary()["signals"]["fluid.middle.velocity_z"]["min"], least);
}

/// Each component has a track; its spans follow each other and add up to what the summary says.
#[test]
fn a_trace_tells_when_components_waited_and_computed() {
    let ran = run_text(SMALL, &["--trace"]).succeeded();
    let text = std::fs::read_to_string(ran.out.join("trace.json")).unwrap();
    let events: Vec<Value> = serde_json::from_str(&text).unwrap();
    let summary = ran.summary();
    let components = summary["components"].as_object().unwrap();
    let tracks: Vec<_> = events.iter().filter(|event| event["ph"] == "M").collect();
    assert_eq!(tracks.len(), components.len());
    for track in tracks {
        let own = &components[track["args"]["name"].as_str().unwrap()];
        let spans: Vec<_> =
            events.iter().filter(|e| e["ph"] == "X" && e["tid"] == track["tid"]).collect();
        for kind in ["compute", "wait", "exchange"] {
            let of_kind = spans.iter().filter(|span| span["name"] == kind);
            let sum: f64 = of_kind.map(|span| span["dur"].as_f64().unwrap()).sum();
            assert!((1e-6 * sum - own[kind].as_f64().unwrap()).abs() < 1e-9, "{kind}");
        }
        for pair in spans.windows(2) {
            let end = pair[0]["ts"].as_f64().unwrap() + pair[0]["dur"].as_f64().unwrap();
            // Clocks that are set while the run goes on may jump a little.
            assert!(pair[1]["ts"].as_f64().unwrap() > end - 1e3, "{pair:?}");
        }
    }
    let few = run_text(SMALL, &["--trace=2-3"]).succeeded();
    let text = std::fs::read_to_string(few.out.join("trace.json")).unwrap();
    let events: Vec<Value> = serde_json::from_str(&text).unwrap();
    let windows: Vec<_> =
        events.iter().filter_map(|event| event["args"]["window"].as_u64()).collect();
    assert!(windows.iter().all(|window| (2..=3).contains(window)));
    assert_eq!(windows.len(), 6 * components.len());
    let wrong = run_text(SMALL, &["--trace=5"]);
    assert!(wrong.errors().contains("0-5000"), "{}", wrong.errors());
}
