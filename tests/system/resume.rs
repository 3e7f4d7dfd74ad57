//! Runs that go on from a checkpoint: to the bits of a run that nothing interrupted, whatever ended
//! them.

use crate::inlets::STREAM;
use crate::profiles::SHOWER;
use crate::rubber::Valve;
use crate::running::{Running, children_of, send, until};
use crate::tremie::{
    Ran, SMALL, description, left_nothing, run, run_text, script, small_with_fluid, tremie,
};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::Duration;
use tremie_sdk::messages::INTERFACE_VERSION;

/// A dam that breaks onto spheres, short and coarse: 113 windows.
const DAM: &str = "examples/dam-break/short.toml";
/// A shock that lifts a hard disc: 20 windows.
const SHOCK: &str = "examples/shock-and-disc/short.toml";

const QUIET: [&str; 3] = ["--quiet", "--set", "outputs.record=false"];

/// Goes on with the run in `out`.
fn resume(out: &Path, options: &[&str]) -> Output {
    tremie().arg("resume").arg(out).arg("--quiet").args(options).output().unwrap()
}

/// Errors of a run that went on.
#[track_caller]
pub fn resumed(out: &Path, options: &[&str]) -> String {
    let output = resume(out, options);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{errors}");
    errors
}

/// Checkpoints of a run, by their windows.
pub fn checkpoints(out: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(out.join("checkpoints")).into_iter().flatten().flatten();
    let mut names: Vec<_> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Checkpoints every so many windows, of which none is removed.
fn every(windows: u64) -> String {
    format!("run.checkpoints={{ windows = {windows}, keep = 99 }}")
}

/// Files of a run that observers wrote.
pub fn files(out: &Path) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for folder in ["", "fields", "profiles"] {
        let entries = std::fs::read_dir(out.join(folder)).into_iter().flatten().flatten();
        let names = entries.map(|e| Path::new(folder).join(e.file_name()).display().to_string());
        found.extend(names.filter(|name| !folder.is_empty() || name == "run.mcap"));
    }
    found.sort();
    found
}

/// How two runs differ, and where both versions of the file that told them apart are kept.
fn difference(one: &Path, other: &Path, file: &str) -> String {
    let kept = tempfile::Builder::new().prefix("differs-").tempdir_in(env!("CARGO_TARGET_TMPDIR"));
    let kept = kept.unwrap().keep();
    for (out, name) in [(one, "one"), (other, "other")] {
        std::fs::copy(out.join(file), kept.join(name)).unwrap();
    }
    let told = tremie().arg("diff").args([one, other]).output().unwrap();
    let told = [told.stdout, told.stderr].concat();
    let told = String::from_utf8_lossy(&told);
    format!("{file} differs; both are in {}\n{told}", kept.display())
}

/// That two runs made the same table, the same files, and the same states at all checkpoints.
#[track_caller]
pub fn assert_same(one: &Path, other: &Path) {
    assert_same_outputs(one, other);
    assert_eq!(checkpoints(one), checkpoints(other));
    assert_same_states(one, other, &checkpoints(one));
}

/// Two runs left the same table, and the same files of observers.
#[track_caller]
pub fn assert_same_outputs(one: &Path, other: &Path) {
    let read = |out: &Path, file: &str| std::fs::read(out.join(file)).unwrap();
    let table = |out: &Path| String::from_utf8(read(out, "signals.csv")).unwrap();
    let (a, b) = (table(one), table(other));
    let line = a.lines().zip(b.lines()).position(|(a, b)| a != b);
    assert_eq!(line, None, "the tables differ from this line on");
    assert_eq!(a.lines().count(), b.lines().count());
    for file in files(one) {
        assert!(read(one, &file) == read(other, &file), "{}", difference(one, other, &file));
    }
    assert_eq!(files(one), files(other));
}

/// Two runs kept the same states in these checkpoints.
#[track_caller]
pub fn assert_same_states(one: &Path, other: &Path, names: &[String]) {
    let read = |out: &Path, file: &str| std::fs::read(out.join(file)).unwrap();
    for name in names.iter().map(|name| PathBuf::from("checkpoints").join(name)) {
        for entry in std::fs::read_dir(one.join(&name)).unwrap() {
            let file = entry.unwrap().file_name().to_string_lossy().into_owned();
            if file.ends_with(".npz") && file != "orchestrator.npz" {
                let file = name.join(&file).to_string_lossy().into_owned();
                assert!(read(one, &file) == read(other, &file), "{file} differs");
            }
        }
    }
}

/// A run that `fault` ends, resumed, beside one without a fault.
#[track_caller]
fn assert_resumes(
    run: impl Fn(&[&str]) -> Ran,
    (windows, fault): (u64, &str),
    options: &[&str],
    then: &[&str],
) {
    let every = every(windows);
    let all = [&QUIET[..], &["--set", &every], options].concat();
    let whole = run(&all).succeeded();
    let broken = run(&[&all[..], &["--inject", fault]].concat());
    assert_eq!(broken.code(), Some(1), "{}", broken.errors());
    assert!(broken.errors().contains("tremie resume"), "{}", broken.errors());
    resumed(&broken.out, then);
    assert_same(&whole.out, &broken.out);
    let windows = |ran: &Ran| ran.summary()["windows"].clone();
    assert_eq!(windows(&whole), windows(&broken));
    assert_eq!(whole.summary()["signals"], broken.summary()["signals"]);
}

#[test]
fn a_fluid_of_particles_and_spheres_go_on_after_any_fault() {
    let dam = |options: &[&str]| run(DAM, options);
    assert_resumes(dam, (20, "fluid:nan@77"), &[], &[]);
    assert_resumes(dam, (16, "grains:kill@50"), &["--schedule", "parallel"], &["--in-process"]);
}

#[test]
fn a_gas_and_hard_spheres_go_on_on_another_number_of_threads() {
    let one = ["--set", "components.fluid.threads=1"];
    let two = ["--set", "components.fluid.threads=2"];
    let shock = |options: &[&str]| run(SHOCK, options);
    assert_resumes(shock, (6, "fluid:exit@11"), &one, &two);
    assert_resumes(shock, (3, "grains:drop@17"), &["--schedule", "parallel"], &[]);
    // In the very window of a checkpoint: the state has what was lost on its way, and the recording's
    // state no word of the fault.
    let record = ["--set", "outputs.record=true"];
    assert_resumes(shock, (3, "fluid:drop@15"), &record, &[]);
}

/// Checkpoints so close to each other that one is being written when a fault ends the run: no observer is
/// lost over it, and none keeps what came after the checkpoint's window.
#[test]
fn a_fault_while_a_checkpoint_is_written_spoils_no_recording() {
    let every = every(2);
    let options =
        ["--quiet", "--schedule", "parallel", "--set", "outputs.record=true", "--set", &every];
    let whole = run_text(SMALL, &options).succeeded();
    for window in [9, 18, 27, 36] {
        let fault = format!("fluid:duplicate@{window}");
        let broken = run_text(SMALL, &[&options[..], &["--inject", &fault]].concat());
        assert!(!broken.errors().contains("is lost"), "{}", broken.errors());
        resumed(&broken.out, &[]);
        assert_same(&whole.out, &broken.out);
    }
}

#[test]
fn a_lattice_with_grains_that_come_and_go_goes_on() {
    let small = |options: &[&str]| run_text(SMALL, options);
    assert_resumes(small, (7, "fluid:kill@30"), &[], &["--in-process"]);
    let stream = |options: &[&str]| run_text(STREAM, options);
    for schedule in ["serial", "parallel"] {
        assert_resumes(stream, (9, "grains:nan@40"), &["--schedule", schedule], &[]);
    }
}

#[test]
fn grains_with_friction_and_profiles_go_on() {
    let shower = |options: &[&str]| run_text(SHOWER, options);
    assert_resumes(shower, (150, "grains:kill@500"), &[], &[]);
}

#[test]
fn spheres_under_a_rubber_ring_go_on() {
    let valve = Valve::on_rough_spheres();
    let pressed = |options: &[&str]| valve.run(options);
    let short = ["--until", "1.2 ms"];
    assert_resumes(pressed, (60, "grains:kill@217"), &short, &[]);
    assert_resumes(pressed, (45, "rubber:kill@188"), &short, &["--in-process"]);
}

/// Starts a run of [`DAM`] with checkpoints, and waits for the first.
fn started(out: &Path, windows: u64) -> Running {
    let mut command = tremie();
    command.arg("run").arg(DAM).arg("--out").arg(out).args(QUIET);
    command.args(["--set", &every(windows)]);
    let running = Running::start(command.stderr(Stdio::null()));
    let has_one = || checkpoints(out).iter().any(|name| name.starts_with("window"));
    until("a first checkpoint", has_one);
    running
}

#[test]
fn a_run_whose_orchestrator_was_killed_goes_on_from_its_newest_checkpoint() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let mut running = started(&out, 20);
    running.send("-KILL");
    running.wait(Duration::from_secs(10));
    // As if it had been killed in the middle of the next.
    let unfinished = out.join("checkpoints/.unfinished-window-000000000099");
    std::fs::create_dir_all(&unfinished).unwrap();
    std::fs::write(unfinished.join("fluid.npz"), "half").unwrap();
    resumed(&out, &[]);
    let whole = run(DAM, &[&QUIET[..], &["--set", &every(20)]].concat()).succeeded();
    assert_same(&whole.out, &out);
}

#[test]
fn a_run_that_was_asked_to_end_goes_on_where_it_ended() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let mut running = started(&out, 50);
    running.send("-TERM");
    assert_eq!(running.wait(Duration::from_secs(20)), Some(130));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let last = summary["windows"].as_u64().unwrap();
    // One window after it, whose row the run that goes on makes again.
    assert_eq!(summary["checkpoint"].as_u64(), Some(last - 1));
    resumed(&out, &[]);
    let whole = run(DAM, &QUIET).succeeded();
    let table = |out: &Path| std::fs::read_to_string(out.join("signals.csv")).unwrap();
    assert_eq!(table(&out), table(&whole.out));
}

/// As a scheduler does at a time limit, or the system as it goes down: each process is asked to end.
#[test]
fn a_run_all_of_whose_processes_are_asked_to_end_ends_in_order() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let mut running = started(&out, 50);
    let components = children_of(running.id());
    assert!(components.len() >= 2, "{components:?}");
    for signal in ["-TERM", "-HUP"] {
        components.iter().for_each(|&component| send(component, signal));
    }
    running.send("-TERM");
    assert_eq!(running.wait(Duration::from_secs(20)), Some(130));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "interrupted");
    assert!(summary["checkpoint"].as_u64().is_some());
}

#[test]
fn a_run_that_goes_on_can_be_longer_but_not_another() {
    let ran = run(SHOCK, &[&QUIET[..], &["--set", &every(8)]].concat()).succeeded();
    let refused = |options: &[&str], words: &[&str]| {
        let output = resume(&ran.out, options);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{errors}");
        words.iter().for_each(|word| assert!(errors.contains(word), "{word}: {errors}"));
    };
    refused(&["--set", "scene.fluid.density=2 kg/m3"], &["scene.fluid.density cannot change"]);
    refused(&["--set", "run.seed=3"], &["run.seed cannot change"]);
    refused(&["--set", "outputs.fram=1 s"], &["did you mean \"frames\"?"]);
    refused(&["--at", "3"], &["no checkpoint of window 3", "8, 16"]);
    assert_eq!(ran.summary()["status"], "completed", "a refusal changes nothing");
    resumed(&ran.out, &["--at", "8", "--until", "60 ms"]);
    let longer = run(SHOCK, &[&QUIET[..], &["--until", "60 ms"]].concat()).succeeded();
    assert_eq!(ran.signals_text(), longer.signals_text());
}

/// A run may go on with the other order of work, while grains come and go: to the same bits in one process,
/// and as a planned change. It stays by the run that had this order from the start.
#[test]
fn a_run_goes_on_with_another_schedule() {
    let home = tempfile::tempdir().unwrap();
    for (first, then) in [("serial", "parallel"), ("parallel", "serial")] {
        let whole = run_text(STREAM, &[&QUIET[..], &["--schedule", then]].concat()).succeeded();
        let every = every(9);
        let options = [&QUIET[..], &["--schedule", first, "--set", &every]].concat();
        let change = format!("run.schedule={then}");
        // Two windows in each of which grains come or go.
        for window in [27, 36] {
            let at = window.to_string();
            let ran = run_text(STREAM, &options).succeeded();
            resumed(&ran.out, &["--at", &at, "--set", &change]);
            let table = ran.signals_text();
            resumed(&ran.out, &["--at", &at, "--set", &change, "--in-process"]);
            assert_eq!(ran.signals_text(), table);
            let planned = home.path().join("planned.jsonl");
            let line = format!(r#"{{"window":{at},"set":[["run.schedule","{then}"]]}}"#);
            std::fs::write(&planned, line).unwrap();
            let planned = ["--changes", planned.to_str().unwrap()];
            let changed = run_text(STREAM, &[&options[..], &planned].concat()).succeeded();
            assert_eq!(changed.signals_text(), table);
            let (mixed, pure) = (ran.signals(), whole.signals());
            let name = "fluid.impulse_delivered_z";
            let since = |of: &BTreeMap<String, Vec<f64>>| of[name][window..].iter().sum::<f64>();
            let (mixed, pure) = (since(&mixed), since(&pure));
            assert!((mixed / pure - 1.0).abs() < 0.02, "{first} then {then}: {mixed} {pure}");
        }
    }
}

#[test]
fn a_damaged_checkpoint_is_named() {
    let ran = run(SHOCK, &[&QUIET[..], &["--set", &every(8)]].concat()).succeeded();
    let file = ran.out.join("checkpoints/window-000000000016/fluid.npz");
    let mut bytes = std::fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&file, &bytes).unwrap();
    let errors = |output: Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let said = errors(resume(&ran.out, &[]));
    assert!(said.contains("fluid") && said.contains("damaged"), "{said}");
    assert_eq!(ran.summary()["status"], "completed", "a refusal changes nothing");
    bytes.truncate(middle);
    std::fs::write(&file, &bytes).unwrap();
    let said = errors(resume(&ran.out, &[]));
    assert!(said.contains("fluid.npz has") && said.contains("--at 8"), "{said}");
    resumed(&ran.out, &["--at", "8"]);
    left_nothing(&ran.summary(), crate::running::now(), "resumed");
}

#[test]
fn a_run_with_a_program_that_keeps_no_state_says_so() {
    let home = tempfile::tempdir().unwrap();
    let lines = format!("read line\necho '{}'\nread line", description(INTERFACE_VERSION));
    let text = small_with_fluid(&script(home.path(), "stateless", &lines));
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let output = tremie().arg("check").arg(&manifest).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("fluid (script) keeps no state: the run cannot be resumed"), "{said}");
    let output = resume(home.path(), &[]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(said.contains("holds no checkpoint"), "{said}");
}

#[test]
fn recordings_fields_and_the_fluid_of_a_beginner_go_on() {
    let files = ["--set", "outputs.record=true", "--set", "outputs.fields=60 ms"];
    let dam = |options: &[&str]| run(DAM, options);
    assert_resumes(dam, (20, "fluid:kill@77"), &files, &[]);
    let minimal =
        |options: &[&str]| run_text(&small_with_fluid(Path::new("minimal-fluid")), options);
    let record = ["--set", "outputs.record=true"];
    assert_resumes(minimal, (9, "grains:kill@25"), &record, &[]);
}

#[test]
fn hashes_and_messages_go_on() {
    // Few frames: rows of hashes wait in the states of the components.
    let keep = ["outputs.record=true", "outputs.messages=true", "outputs.frames=4 ms"];
    let keep: Vec<&str> = keep.iter().flat_map(|set| ["--set", set]).collect();
    let small = |options: &[&str]| run_text(SMALL, options);
    assert_resumes(small, (7, "fluid:kill@30"), &keep, &["--in-process"]);
    assert_resumes(
        small,
        (9, "grains:drop@27"),
        &[&keep[..], &["--schedule", "parallel"]].concat(),
        &[],
    );
    let valve = Valve::on_rough_spheres();
    let pressed = |options: &[&str]| valve.run(options);
    let short = [&keep[..], &["--until", "0.4 ms"]].concat();
    assert_resumes(pressed, (30, "rubber:kill@77"), &short, &[]);
}

/// A fluid that a force makes too fast for its lattice, so that it is no number at the same window in every
/// try.
const TOO_FAST: &str = r#"
[run]
until = "2 s"
checkpoints = { windows = 5 }

[scene]

[scene.domain]
size = ["8 mm", "8 mm", "8 mm"]
x = "periodic"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "1e-3 Pa s"
acceleration = ["4 m/s2", "0 m/s2", "0 m/s2"]
expected_speed = "0.05 m/s"

[components]
fluid = "fluid-lbm"

[settings.fluid-lbm]
cell = "0.5 mm"

[watch]
mach = "off"
density = "off"
mass = "off"

[outputs]
record = false
"#;

#[test]
fn a_run_goes_on_by_itself_after_a_fault_unless_the_window_fails_again() {
    let shock = ["--set", "run.checkpoints.windows=6", "--restart-on-fault", "2"];
    let all = [&QUIET[..], &shock].concat();
    let broken = run(SHOCK, &[&all[..], &["--inject", "grains:kill@15"]].concat()).succeeded();
    let whole = run(SHOCK, &all).succeeded();
    assert_eq!(broken.signals_text(), whole.signals_text());
    left_nothing(&broken.summary(), broken.ended, "restarted");

    let hopeless = run_text(TOO_FAST, &["--restart-on-fault", "9"]);
    assert_eq!(hopeless.code(), Some(1));
    let said = hopeless.errors();
    assert!(said.contains("failed twice: the run is given up"), "{said}");
    assert_eq!(said.matches("goes on by itself").count(), 1, "{said}");
}
