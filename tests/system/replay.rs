//! `tremie replay`: a component against the recorded messages of the others sends the recorded bits, and one
//! with another parameter is found out.

use crate::rubber::Valve;
use crate::tremie::{Ran, SMALL, run_text, tremie};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const MESSAGES: [&str; 5] =
    ["--quiet", "--set", "outputs.record=true", "--set", "outputs.messages=true"];

/// Replays a component: exit code, and all that was said.
fn replay(out: &Path, component: &str, options: &[&str]) -> (Option<i32>, String) {
    let mut command = tremie();
    command.arg("replay").arg(out).args(["--only", component, "--quiet"]).args(options);
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(said).unwrap())
}

#[track_caller]
fn assert_same(ran: &Ran, component: &str, options: &[&str]) {
    assert!(!ran.errors().contains("is lost"), "{}", ran.errors());
    let last = ran.summary()["windows"].as_u64().unwrap();
    let (code, said) = replay(&ran.out, component, options);
    assert_eq!(code, Some(0), "{said}");
    let from = if options.contains(&"--at") { 1 + options[1].parse::<u64>().unwrap() } else { 1 };
    let expected = format!("the recorded bits: {component}, windows {from} to {last}");
    assert!(said.contains(&expected), "{said}");
}

#[track_caller]
fn assert_differs(ran: &Ran, component: &str, options: &[&str], words: &[&str]) -> String {
    let (code, said) = replay(&ran.out, component, options);
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("other bits than recorded: "), "{said}");
    words.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
    said
}

/// Lengths and times of all files below a folder.
fn files(folder: &Path) -> BTreeMap<String, (u64, std::time::SystemTime)> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            let file = path.metadata().unwrap();
            found.insert(path.display().to_string(), (file.len(), file.modified().unwrap()));
        }
    }
    found
}

#[test]
fn fluid_and_grains_send_the_recorded_bits_and_leave_the_run_alone() {
    for schedule in ["serial", "parallel"] {
        let options = [&MESSAGES[..], &["--schedule", schedule]].concat();
        let ran = run_text(SMALL, &options).succeeded();
        let before = files(&ran.out);
        assert_same(&ran, "fluid", &[]);
        assert_same(&ran, "grains", &["--in-process"]);
        assert_eq!(files(&ran.out), before);
    }
}

#[test]
fn a_component_with_another_parameter_is_found_out() {
    let ran = run_text(SMALL, &[&MESSAGES[..], &["--until", "0.1 s"]].concat()).succeeded();
    let precision = ["--set", "settings.fluid-lbm.precision=f32"];
    let words = ["fluid -> grains, load, window 1: ", "body 0, force.z: ", "ulp)"];
    assert_differs(&ran, "fluid", &precision, &words);
    let friction = ["--set", "scene.contacts[0].friction=0.31"];
    let words = ["grains -> fluid, state, window ", "body 0, position.x: ", "ulp)"];
    assert_differs(&ran, "grains", &friction, &words);
    // The same change does nothing to the fluid.
    assert_same(&ran, "fluid", &friction);

    let output = tremie()
        .arg("replay")
        .arg(&ran.out)
        .args(["--only", "grains", "--json"])
        .args(friction)
        .output()
        .unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let last: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    assert_eq!((&last["event"], &last["summary"]["same"]), (&"end".into(), &false.into()));
    assert_eq!(last["summary"]["difference"]["blamed"], "grains");
    assert!(last["summary"]["difference"]["window"].as_u64() > Some(100), "{said}");
}

#[test]
fn a_replay_begins_at_a_checkpoint_where_there_is_one() {
    let every = ["--until", "0.1 s", "--set", "run.checkpoints={ windows = 50, keep = 99 }"];
    let ran = run_text(SMALL, &[&MESSAGES[..], &every].concat()).succeeded();
    assert_same(&ran, "grains", &["--at", "150"]);
    assert_same(&ran, "fluid", &["--at", "50", "--in-process"]);
    let (code, said) = replay(&ran.out, "grains", &["--at", "15"]);
    assert_eq!(code, Some(2));
    assert!(said.contains("no checkpoint of window 15"), "{said}");
    let friction = ["--at", "150", "--set", "scene.contacts[0].friction=0.31"];
    assert_differs(&ran, "grains", &friction, &["grains -> fluid, state, window "]);
}

/// Changes of a run in progress are made in its replay at the same windows, also after a checkpoint between
/// them. A replay without one of them has other bits from its window on.
#[test]
fn changes_of_a_run_in_progress_are_replayed() {
    let home = tempfile::tempdir().unwrap();
    let changes = home.path().join("changes.jsonl");
    let lines = [
        r#"{"window":20,"set":[["scene.gravity[2]","-5 m/s2"]]}"#,
        r#"{"window":60,"set":[["run.schedule","parallel"],["scene.contacts[0].friction","0.4"]]}"#,
    ];
    std::fs::write(&changes, lines.join("\n")).unwrap();
    let every = ["--until", "0.1 s", "--set", "run.checkpoints={ windows = 50, keep = 99 }"];
    let changed = ["--changes", changes.to_str().unwrap()];
    let ran = run_text(SMALL, &[&MESSAGES[..], &every, &changed].concat()).succeeded();
    let before = files(&ran.out);
    assert_same(&ran, "fluid", &[]);
    assert_same(&ran, "grains", &["--in-process"]);
    assert_same(&ran, "grains", &["--at", "50"]);
    assert_same(&ran, "fluid", &["--at", "60"]);
    assert_eq!(files(&ran.out), before);

    std::fs::write(ran.out.join("steering.jsonl"), lines[0]).unwrap();
    let words = ["fluid -> grains, load, window 61: "];
    assert_differs(&ran, "fluid", &[], &words);
}

#[test]
fn rubber_and_grains_are_replayed_within_their_windows() {
    let valve = Valve::on_rough_spheres();
    let ran = valve.run(&[&MESSAGES[..], &["--until", "0.4 ms"]].concat()).succeeded();
    assert_same(&ran, "rubber", &[]);
    assert_same(&ran, "grains", &["--in-process"]);
    let damping = ["--set", "scene.parts[0].motion.slider.mass=9.3 g"];
    let words = ["grains -> rubber, carrier, window ", "substep ", "surface 0, "];
    assert_differs(&ran, "grains", &damping, &words);

    let home = tempfile::tempdir().unwrap();
    let changes = home.path().join("changes.jsonl");
    std::fs::write(&changes, r#"{"window":40,"set":[["scene.gravity[2]","-500 m/s2"]]}"#).unwrap();
    let changes = ["--until", "0.4 ms", "--changes", changes.to_str().unwrap()];
    let changed = valve.run(&[&MESSAGES[..], &changes].concat()).succeeded();
    assert_ne!(changed.signals_text(), ran.signals_text());
    assert_same(&changed, "rubber", &[]);
    assert_same(&changed, "grains", &["--in-process"]);
}

#[test]
fn what_a_replay_needs_is_said() {
    let ran = run_text(SMALL, &["--quiet", "--set", "outputs.record=true"]).succeeded();
    let (code, said) = replay(&ran.out, "fluid", &[]);
    assert_eq!(code, Some(2));
    assert!(said.contains("record the run with outputs.messages = true"), "{said}");
    let (code, said) = replay(&ran.out, "rubber", &[]);
    assert_eq!(code, Some(2));
    assert!(said.contains("no component \"rubber\"") && said.contains("fluid, grains"), "{said}");

    let ran = run_text(SMALL, &MESSAGES).succeeded();
    let (code, said) = replay(&ran.out, "fluid", &["--set", "settings.fluid-lbm.cell=0.4 mm"]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("the recorded messages do not fit it"), "{said}");
}
