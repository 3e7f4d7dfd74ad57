//! Watchdogs: runs whose physics goes wrong stop by themselves, with the place, and leave a
//! checkpoint from before.

use crate::resume::checkpoints;
use crate::tremie::{Ran, run, run_text, tremie};
use serde_json::Value;
use std::path::Path;

/// A channel whose inlet becomes faster: 0.2 m/s in a second. The lattice's speed of sound is 0.5
/// m/s: Mach 0.1 near window 370, Mach 0.17 at window 612.
const CHANNEL: &str = r#"
[run]
until = "0.4 s"
checkpoints = { every = "1 h" }

[scene.domain]
size = ["12 mm", "6 mm", "6 mm"]
x = { lower = { velocity = ["0.2 m/s", "0 m/s", "0 m/s"], ramp = "1 s" }, upper = { pressure = "0 Pa", outflow = "absorbing" } }
y = "symmetry"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "2 mPa s"
expected_speed = "0.05 m/s"

[components]
fluid = "fluid-lbm"

[settings.fluid-lbm]
cell = "0.5 mm"

[outputs]
record = false
"#;

/// A sphere that falls onto a fixed one, on springs that are far too soft.
const SOFT: &str = r#"
[run]
until = "20 ms"
checkpoints = { every = "1 h" }

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["10 mm", "10 mm", "20 mm"]

[[scene.bodies]]
name = "low"
density = "2500 kg/m3"
motion = "fixed"
spheres = [{ position = ["5 mm", "5 mm", "3 mm"], diameter = "4 mm" }]

[[scene.bodies]]
name = "high"
density = "2500 kg/m3"
spheres = [{ position = ["5 mm", "5 mm", "8 mm"], diameter = "4 mm", velocity = ["0 m/s", "0 m/s", "-0.3 m/s"] }]

[[scene.contacts]]
normal_stiffness = "4 N/m"
tangential_stiffness = "2 N/m"
restitution = 0.9

[components]
grains = "grains-dem"

[settings.grains-dem]
time_step = "10 us"

[outputs]
record = false
"#;

/// A shock that runs into a wall.
const SHOCK: &str = r#"
[run]
until = "70 us"
checkpoints = { windows = 40 }

[scene.domain]
size = ["32 mm", "10 mm", "4 mm"]
across = "y"
x = { lower = { pressure = "0 Pa", outflow = "absorbing" }, upper = "wall" }
z = "symmetry"

[scene.fluid]
density = "1.2 kg/m3"
viscosity = "18 uPa s"

[scene.fluid.gas]
pressure = "100 kPa"
shock = { axis = "x", position = "8 mm", mach = 1.66 }

[components]
fluid = "fluid-wavelet"

[settings.fluid-wavelet]
cell = "0.25 mm"

[watch]
density = 0.5

[outputs]
record = false
"#;

/// The fault and the breach of a run that its physics ended.
#[track_caller]
fn breach(ran: &Ran) -> (Value, Value) {
    assert_eq!(ran.code(), Some(1), "{}", ran.errors());
    let summary = ran.summary();
    assert_eq!(
        (&summary["status"], &summary["fault"]["kind"]),
        (&"failed".into(), &"physics".into())
    );
    assert_eq!(summary["fault"]["window"], summary["breach"]["window"]);
    (summary["fault"].clone(), summary["breach"].clone())
}

/// Goes on as the run's last line says, with `options`; its errors if it fails.
fn go_on(ran: &Ran, options: &[&str]) -> Result<(), String> {
    let at = breach(ran).1["checkpoint"].as_u64().expect("a checkpoint from before").to_string();
    let mut command = tremie();
    command.arg("resume").arg(&ran.out).args(["--quiet", "--at", &at]).args(options);
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.success() { Ok(()) } else { Err(errors) }
}

fn within(place: &Value, lower: [f64; 3], upper: [f64; 3]) -> bool {
    (0..3).all(|a| place[a].as_f64().is_some_and(|x| lower[a] <= x && x <= upper[a]))
}

#[test]
fn a_flow_that_becomes_too_fast_stops_with_its_place_and_goes_on_under_another_limit() {
    let ran = run_text(CHANNEL, &[]);
    let (fault, breach) = breach(&ran);
    let said = ran.errors();
    for words in [
        "the run stops above 0.17 (watch.mach)",
        "fluid failed at window",
        "above the limit of 0.17 (watch.mach)",
        ") m",
        "what helps: a shorter time step",
        "goes on from window",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    assert_eq!((&fault["blamed"], &breach["signal"]), (&"fluid".into(), &"fluid.max_mach".into()));
    assert!(breach["value"].as_f64().unwrap() > 0.17, "{breach}");
    assert!(within(&breach["place"]["position"], [0.0; 3], [12e-3, 6e-3, 6e-3]), "{breach}");
    let (window, before) = (breach["window"].as_u64().unwrap(), breach["checkpoint"].as_u64());
    // The first level, Mach 0.1, was passed more than 200 windows before.
    assert!(before.is_some_and(|before| before + 100 < window), "{breach}");
    assert!(said.contains(&format!("--at {} --set watch.mach=0.34", before.unwrap())), "{said}");
    ran.left_nothing("a breach");
    let again = go_on(&ran, &[]).unwrap_err();
    assert!(again.contains("above the limit of 0.17 (watch.mach)"), "{again}");
    assert_eq!(ran.summary()["breach"]["window"], window, "the same window again");
    go_on(&ran, &["--set", "watch.mach=0.3"]).unwrap();
    assert_eq!(ran.summary()["status"], "completed");
    // The bits are those of a run that nothing stopped.
    let off = run_text(CHANNEL, &["--set", "watch.mach=off"]).succeeded();
    assert_eq!(ran.signals_text(), off.signals_text());
    assert!(off.summary()["signals"]["fluid.max_mach"]["max"].as_f64().unwrap() > 0.17);
    assert_eq!(checkpoints(&off.out), Vec::<String>::new(), "nothing is watched");
}

#[test]
fn a_run_stops_at_the_same_window_however_it_is_carried_out() {
    // Which checkpoint is the newest depends on how far ahead components had leave to go.
    let of_run = |ran: Ran| {
        let (fault, mut breach) = breach(&ran);
        breach["checkpoint"].take();
        (fault, breach)
    };
    let of = |options: &[&str]| of_run(run_text(CHANNEL, options));
    let one = of(&["--set", "components.fluid.threads=1"]);
    for options in [
        &["--set", "components.fluid.threads=2"][..],
        &["--in-process", "--quiet"],
        &["--set", "outputs.record=true", "--set", "outputs.frames=5 ms"],
    ] {
        assert_eq!(of(options), one, "{options:?}");
    }
    // What the fluid does after the breach does not matter.
    let next = one.1["window"].as_u64().unwrap() + 1;
    assert_eq!(of(&["--inject", &format!("fluid:exit@{next}")]), one);
    let soft = |options: &[&str]| of_run(run_text(SOFT, options));
    assert_eq!(soft(&["--in-process"]), soft(&["--set", "components.grains.threads=1"]));
}

#[test]
fn spheres_that_sink_into_each_other_are_named() {
    let ran = run_text(SOFT, &["--restart-on-fault", "3"]);
    let (fault, breach) = breach(&ran);
    assert_eq!(breach["signal"], "grains.max_overlap_ratio");
    assert_eq!(breach["place"]["bodies"], serde_json::json!([0, 1]));
    let message = fault["message"].as_str().unwrap();
    assert!(
        message.contains("of body 0 with body 1 at (0.005, 0.005, 0.003) m is 0.5"),
        "{message}"
    );
    assert!(message.contains("what helps: a larger normal_stiffness"), "{message}");
    assert!(!ran.errors().contains("goes on by itself"), "it would fail again: {}", ran.errors());
    assert!(breach["checkpoint"].as_u64() < breach["window"].as_u64(), "{breach}");
    go_on(&ran, &["--set", "watch.overlap=0.95"]).unwrap();
    assert_eq!(ran.summary()["status"], "completed");
}

#[test]
fn a_gas_stops_and_its_newest_checkpoint_from_before_stays() {
    let ran = run_text(SHOCK, &[]);
    let (_, breach) = breach(&ran);
    assert_eq!(breach["signal"], "fluid.density_deviation");
    // At the wall from which the shock comes back.
    assert!(
        within(&breach["place"]["position"], [30e-3, 0.0, 0.0], [32e-3, 10e-3, 4e-3]),
        "{breach}"
    );
    let before = breach["checkpoint"].as_u64().unwrap();
    assert!(before < breach["window"].as_u64().unwrap(), "{breach}");
    let newest = checkpoints(&ran.out).pop().unwrap();
    assert_eq!(newest, format!("window-{before:012}"), "none of the breach or later");
    go_on(&ran, &["--set", "watch.density=off"]).unwrap();
    assert_eq!(ran.summary()["status"], "completed");
}

#[test]
fn particles_that_skip_cells_stop_where_they_fly() {
    let options = ["--quiet", "--set", "outputs.record=false", "--set", "watch.speed=0.4"];
    let ran = run("examples/dam-break/short.toml", &options);
    let (_, breach) = breach(&ran);
    assert_eq!(breach["signal"], "fluid.courant");
    assert!(within(&breach["place"]["position"], [0.0; 3], [1.2, 0.3, 0.6]), "{breach}");
}

#[test]
fn a_checkpoint_that_was_asked_for_outlives_later_ones() {
    let options = ["--set", "run.checkpoints={ windows = 20, keep = 1 }"];
    let ran = run_text(CHANNEL, &options);
    let (_, breach) = breach(&ran);
    let left = checkpoints(&ran.out);
    assert_eq!(left.len(), 2, "{left:?}");
    let record = |name: &str| {
        let file = ran.out.join("checkpoints").join(name).join("checkpoint.json");
        serde_json::from_str::<Value>(&std::fs::read_to_string(file).unwrap()).unwrap()
    };
    let [asked, newest] = [0, 1].map(|k| record(&left[k]));
    assert_eq!(asked["made_for"], "fluid.max_mach", "{asked}");
    assert_eq!((&newest["made_for"], &newest["window"]), (&Value::Null, &breach["checkpoint"]));
    let none = run_text(CHANNEL, &["--set", "run.checkpoints={ keep = 0 }"]);
    assert_eq!(checkpoints(&none.out), Vec::<String>::new());
    assert!(none.errors().contains("no checkpoint is from before that"), "{}", none.errors());
}

#[test]
fn a_value_that_swings_about_its_level_writes_few_checkpoints() {
    let swinging = CHANNEL
        .replace("\"0.2 m/s\"", "\"0.048 m/s\"")
        .replace("ramp = \"1 s\"", "course = { sine = { frequency = \"10 Hz\" } }")
        .replace("\"0.4 s\"", "\"1.5 s\"");
    let ran = run_text(&swinging, &["--set", "run.checkpoints={ every = \"1 h\", keep = 99 }"])
        .succeeded();
    let mach = &ran.signals()["fluid.max_mach"];
    let crossings = mach.windows(2).filter(|pair| pair[0] <= 0.1 && pair[1] > 0.1).count();
    let written = checkpoints(&ran.out).len();
    assert!(crossings > 20, "{crossings}");
    assert!((1..=9).contains(&written), "{written} of {crossings} crossings");
    assert_eq!(ran.errors().matches("the run stops above 0.17").count(), 1, "{}", ran.errors());
}

#[test]
fn wrong_limits_are_refused_at_their_lines() {
    let refused = |line: &str, words: &[&str]| {
        let ran = run_text(&format!("{CHANNEL}\n[watch]\n{line}\n"), &[]);
        assert_eq!(ran.code(), Some(2), "{}", ran.errors());
        let said = ran.errors();
        words.iter().for_each(|word| assert!(said.contains(word), "{word}: {said}"));
    };
    refused("mach = -0.1", &["watch.mach", "manifest.toml:26", "found -0.1", "\"off\""]);
    refused("mach = 0", &["watch.mach", "found 0", "expected a finite number above zero"]);
    refused(
        "mach = \"none\"",
        &["watch.mach", "found \"none\"", "a number above zero, or \"off\""],
    );
    refused("match = 0.1", &["unknown key \"match\"", "did you mean \"mach\"?"]);
    refused("mach = [0.1]", &["watch.mach", "a number above zero, or \"off\""]);
}

/// The plan of a manifest, as `check` tells programs.
fn plan(text: &str, options: &[&str]) -> Value {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let check = |path: &Path| tremie().arg("check").arg(path).args(options).output().unwrap();
    let output = check(&manifest);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut events = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    events.find(|event| event["event"] == "plan").unwrap_or_else(|| panic!("{text}"))
}

#[test]
fn check_says_which_limits_hold() {
    let all = [
        "--json",
        "--set",
        "watch.density=0.05",
        "--set",
        "watch.mass=off",
        "--set",
        "watch.overlap=0.2",
    ];
    let found = plan(CHANNEL, &all);
    let watches = serde_json::json!([
        { "signal": "fluid.max_mach", "quantity": "mach", "from": 0.1, "limit": 0.17 },
        { "signal": "fluid.max_density_deviation", "quantity": "density", "from": 0.025, "limit": 0.05 },
    ]);
    assert_eq!(found["plan"]["watches"], watches);
    let lines = found["lines"].to_string();
    assert!(lines.contains("checkpoint above") && lines.contains("set by"), "{lines}");
    assert!(lines.contains("watch.overlap is not used"), "{lines}");
    // The settings of the lattice say where its limit lies, unless the manifest does.
    let limit = |options: &[&str]| {
        let found = plan(CHANNEL, &[&["--json"], options].concat());
        found["plan"]["watches"][0]["limit"].clone()
    };
    let own = ["--set", "settings.fluid-lbm.mach_limit=0.3"];
    assert_eq!(limit(&own), 0.3);
    assert_eq!(limit(&[&own[..], &["--set", "watch.mach=0.2"]].concat()), 0.2);
}
