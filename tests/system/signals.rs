//! What a run reports, and what that means.

use crate::inlets::STREAM;
use crate::tremie::{run_text, tremie};
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
