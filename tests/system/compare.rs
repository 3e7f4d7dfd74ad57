//! `tremie diff`: hashes of equal runs are equal, and where runs differ, the window, the channel, the body
//! and the size of the difference are found.

use crate::tremie::{Ran, SMALL, run_text, small_with_fluid, tremie};
use serde_json::Value;
use std::path::Path;
use tremie_messages::bytes_of;
use tremie_messages::schedule::Content;
use tremie_recorder::{Item, Recording};

const RECORD: [&str; 3] = ["--quiet", "--set", "outputs.record=true"];
const MESSAGES: [&str; 2] = ["--set", "outputs.messages=true"];

fn small(options: &[&str]) -> Ran {
    run_text(SMALL, &[&RECORD[..], options].concat()).succeeded()
}

/// Compares two runs: exit code, and all that was said.
fn diff(one: &Path, other: &Path, options: &[&str]) -> (Option<i32>, String) {
    let output = tremie().arg("diff").args([one, other]).args(options).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[track_caller]
fn assert_equal(one: &Ran, other: &Ran) -> String {
    let (code, said) = diff(&one.out, &other.out, &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("\nequal: ") || said.starts_with("equal: "), "{said}");
    said
}

/// All hashes of a recording: sender, window, and the hashes of its channels.
fn hashes(ran: &Ran) -> Vec<(String, Vec<u64>)> {
    let recording = Recording::open(&ran.out.join("run.mcap")).unwrap();
    let mut found = Vec::new();
    for item in recording.items() {
        if let Item::Hashes { from, channels, rows, .. } = item.unwrap() {
            found.extend(rows.chunks(1 + channels.len()).map(|row| (from.clone(), row.to_vec())));
        }
    }
    found.sort();
    found
}

#[test]
fn runs_on_other_threads_and_in_one_process_are_equal() {
    let once = small(&[]);
    let windows = once.summary()["windows"].as_u64().unwrap();
    let rows = hashes(&once);
    // Each component has a row of the start exchange, and one of each window.
    assert_eq!(rows.len() as u64, 2 * (windows + 1));
    assert!(rows.iter().all(|(_, row)| row[1..].iter().all(|hash| *hash != 0)));
    let mut different: Vec<_> = rows.iter().flat_map(|(_, row)| row[1..].to_vec()).collect();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len() as u64, 3 * (windows + 1), "no two messages are alike");

    let said = assert_equal(&once, &small(&["--in-process"]));
    assert!(said.contains(&format!("equal: {windows} windows, hashes of 3 channels")), "{said}");
    let threads = "components.fluid={ program = \"fluid-lbm\", threads = 2 }";
    let said = assert_equal(&once, &small(&["--set", threads]));
    assert!(said.contains("manifest: components.fluid.threads differs"), "{said}");
    // Frames at another rate are other frames, of the same run.
    let rarely = small(&["--set", "outputs.frames=7 ms"]);
    assert_eq!(hashes(&rarely), rows);
    assert_equal(&once, &rarely);
}

/// The small manifest with a body that lies elsewhere by 1e-12 of its place.
fn moved() -> String {
    let moved = SMALL
        .replace("[\"8 mm\", \"8 mm\", \"8 mm\"]", "[\"8.000000000008 mm\", \"8 mm\", \"8 mm\"]");
    assert_ne!(moved, SMALL);
    moved
}

#[test]
fn a_body_that_lies_elsewhere_by_little_is_found_from_the_start() {
    let options = [&RECORD[..], &MESSAGES].concat();
    let one = run_text(SMALL, &options).succeeded();
    let other = run_text(&moved(), &options).succeeded();
    let (code, said) = diff(&one.out, &other.out, &[]);
    assert_eq!(code, Some(1), "{said}");
    for words in [
        "manifest: scene.bodies[0].spheres[1].position",
        "hashes: window 0 is the first that differs, in grains -> fluid, state",
        "message: grains -> fluid, state, window 0: 1 number differs",
        "body 1, position.x: 0.008 and 0.008000000000008 (differs by 8.0",
        "relative 1.0",
        "the runs differ from the start: grains -> fluid, state",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert!(!said.contains("body 0") && !said.contains("body 2"), "{said}");

    // Without messages, frames tell it.
    let seen = run_text(&moved(), &RECORD).succeeded();
    let (_, said) = diff(&one.out, &seen.out, &[]);
    assert!(said.contains("frames: /bodies/grains, window 0"), "{said}");
    assert!(said.contains("body 1, position.x: 0.008 and 0.008000000000008"), "{said}");

    let (code, said) = diff(&one.out, &other.out, &["--json"]);
    assert_eq!(code, Some(1));
    let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let found = &lines[0]["recordings"];
    assert_eq!((&lines[0]["event"], &found["hashes"]["window"]), (&"difference".into(), &0.into()));
    let first = &found["place"]["differences"]["first"][0];
    assert_eq!((&first["of"], &first["field"]), (&"body 1".into(), &"position.x".into()));
    assert_eq!(lines[1]["equal"], false);
}

#[test]
fn a_difference_in_the_middle_of_a_run_is_found_at_its_window() {
    // Grains meet, and feel friction, only late.
    let other = ["--set", "scene.contacts[0].friction=0.31"];
    let until = [&MESSAGES[..], &["--until", "0.1 s"]].concat();
    let messages = |options: &[&str]| small(&[&until[..], options].concat());
    let (one, two) = (messages(&[]), messages(&other));
    let (code, said) = diff(&one.out, &two.out, &["--json"]);
    assert_eq!(code, Some(1), "{said}");
    let found: Value = serde_json::from_str(said.lines().next().unwrap()).unwrap();
    let window = found["recordings"]["hashes"]["window"].as_u64().unwrap();
    assert!(window > 100, "{said}");
    let (mine, theirs) = (hashes(&one), hashes(&two));
    let first = mine.iter().zip(&theirs).filter(|(a, b)| a != b).map(|(a, _)| a.1[0]).min();
    assert_eq!(first, Some(window));
    let place = &found["recordings"]["place"];
    assert_eq!((&place["window"], &place["is_message"]), (&window.into(), &true.into()));
    assert_eq!(place["at"], "grains -> fluid, state");
    assert!(found["signals"]["count"].as_u64() > Some(0), "{said}");
}

#[test]
fn runs_of_other_lengths_and_without_recordings_are_compared_as_far_as_they_go() {
    let (long, short) = (small(&[]), small(&["--until", "0.01 s"]));
    let (code, said) = diff(&long.out, &short.out, &[]);
    assert_eq!(code, Some(1), "{said}");
    let last = short.summary()["windows"].as_u64().unwrap();
    assert!(said.contains(&format!("equal up to window {last}, where OUT2 ends")), "{said}");

    let plain = run_text(SMALL, &["--quiet"]).succeeded();
    let said = assert_equal(&plain, &run_text(SMALL, &["--quiet", "--in-process"]).succeeded());
    assert!(said.contains("note: ") && said.contains("rows of"), "{said}");

    let (code, said) = diff(&long.out, Path::new("no/such/folder"), &[]);
    assert_eq!(code, Some(2));
    assert!(said.contains("cannot read no/such/folder"), "{said}");
}

#[test]
fn all_messages_are_kept_in_their_order() {
    let ran = small(&MESSAGES);
    let windows = ran.summary()["windows"].as_u64().unwrap();
    let recording = Recording::open(&ran.out.join("run.mcap")).unwrap();
    let mut count = 0;
    let (mut state, mut seen) = (Vec::new(), Vec::new());
    for item in recording.items() {
        match item.unwrap() {
            Item::Message { at, channel, values, .. } => {
                assert_eq!(at.stamp.run, 0);
                count += 1;
                if channel.content == Content::State && at.stamp.window == windows {
                    state = values;
                }
            }
            Item::Bodies { at, bodies, .. } if at.stamp.window == windows => {
                seen = bodies.iter().map(|body| body.state).collect();
            }
            _ => {}
        }
    }
    assert_eq!(count, 3 * (windows + 1));
    assert_eq!(bytes_of(&seen), state, "an observer sees what the fluid is sent");
    assert_eq!(seen.len(), 3);
}

#[test]
fn a_fluid_of_a_beginner_is_hashed_too() {
    let minimal = small_with_fluid(Path::new("minimal-fluid"));
    let run = || run_text(&minimal, &RECORD).succeeded();
    let said = assert_equal(&run(), &run());
    assert!(said.contains("hashes of 3 channels"), "{said}");
}

#[test]
fn messages_need_a_recording() {
    let output = tremie()
        .args(["check", "examples/dam-break/short.toml"])
        .args(["--set", "outputs.record=false", "--set", "outputs.messages=true"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("outputs.messages") && said.contains("outputs.record = true"), "{said}");
}

#[test]
fn the_doctor_counts_the_room_that_messages_take() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL).unwrap();
    let check = |options: &[&str]| -> Value {
        let mut command = tremie();
        command.arg("check").arg(&manifest).args(["--json", "--set", "outputs.record=true"]);
        let output = command.args(options).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap();
        let mut events = said.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        events.find(|event| event["event"] == "plan").unwrap()
    };
    let disk = |plan: &Value| {
        let findings = plan["findings"].as_array().unwrap();
        let disk = findings.iter().find(|finding| finding["quantity"] == "disk, at most").unwrap();
        disk["value"].as_f64().unwrap()
    };
    let (without, with) = (check(&[]), check(&MESSAGES));
    let windows = with["plan"]["windows"].as_f64().unwrap();
    // Three bodies: events of 64 bytes, states of 112, loads of 56, and three heads of 56.
    let window = (3 * (64 + 112 + 56) + 3 * 56) as f64;
    assert_eq!(disk(&with) - disk(&without), (windows + 1.0) * window);
}
