//! Signals of a run, and their meanings.

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

/// A probe is measured where a row is kept and in the last window. It has the same bits as if it
/// were measured in every window, with and without observers. Extremes and conditions see the
/// measured values.
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

/// Balls that fall through a gate in rows that are kept rarely, and at times that the end is none
/// of.
const FALLING: &str = r#"
[run]
until = "0.2 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["0.1 m", "0.1 m", "0.3 m"]

[[scene.bodies]]
name = "balls"
density = "2500 kg/m3"
spheres = [
    { position = ["20 mm", "50 mm", "250 mm"], diameter = "10 mm" },
    { position = ["50 mm", "50 mm", "220 mm"], diameter = "10 mm" },
    { position = ["80 mm", "50 mm", "190 mm"], diameter = "10 mm", velocity = ["0 m/s", "0 m/s", "0.6 m/s"] },
]

[[scene.contacts]]
normal_stiffness = "1e4 N/m"
tangential_stiffness = "8e3 N/m"
restitution = 0.5

[[scene.probes]]
name = "gate"
section = { axis = "z", at = "200 mm" }

[components]
grains = "grains-dem"

[outputs]
record = false
"#;

/// A section keeps its count since the start, and its rate is a mean from row to row. So all rows
/// together give the mass that passed, whatever the rows are and whoever looks.
#[test]
fn rates_of_rows_add_up_to_what_passed() {
    for (rows, frames) in [("20 ms", None), ("1 ns", None), ("7 ms", Some("3 ms")), ("1 s", None)] {
        let outputs = frames.map_or(String::new(), |every| format!("\nframes = \"{every}\""));
        let record = format!("record = {}\nsignals = \"{rows}\"{outputs}", frames.is_some());
        let ran = run_text(&FALLING.replace("record = false", &record), &[]).succeeded();
        let signals = ran.signals();
        let [times, rates, crossings, passed] = [
            "time",
            "grains.gate.mass_flow_rate",
            "grains.gate.crossings",
            "grains.gate.mass_passed",
        ]
        .map(|name| &signals[name]);
        let pairs = times.windows(2).zip(&rates[1..]);
        let sum: f64 = pairs.map(|(pair, rate)| (pair[1] - pair[0]) * rate).sum();
        let (all, ball) = (passed.last().unwrap(), 2500.0 * std::f64::consts::PI / 6.0 * 1e-6);
        // One goes up and comes down again; the two above fall through.
        assert!((all / (-2.0 * ball) - 1.0).abs() < 1e-9, "{rows}: {all}");
        assert!((sum / all - 1.0).abs() < 1e-9, "{rows}: {sum} {all}");
        for (count, mass) in crossings.iter().zip(passed) {
            assert!((count * ball - mass).abs() < 1e-9 * ball, "{rows}: {count} {mass}");
        }
        assert_eq!(*crossings.last().unwrap(), -2.0, "{rows}");
        let told = &ran.summary()["signals"]["grains.gate.mass_flow_rate"];
        assert_eq!(told["min"], rates.iter().copied().fold(f64::INFINITY, f64::min), "{rows}");
    }
}

/// A fluid at rest with a fixed ball, a slider, a prescribed part, a body and a clump. Forces of
/// the fluid on them mean the same, and have the same value.
const RESTING: &str = r#"
[run]
until = "2 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["40 mm", "10 mm", "10 mm"]

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
expected_speed = "0.1 m/s"

[[scene.parts]]
name = "fixed"
sphere = { radius = "2 mm" }
position = ["5 mm", "5.1 mm", "5.2 mm"]

[[scene.parts]]
name = "held"
sphere = { radius = "2 mm" }
position = ["12 mm", "5.1 mm", "5.2 mm"]
motion = "prescribed"

[[scene.parts]]
name = "slides"
sphere = { radius = "2 mm" }
position = ["19 mm", "5.1 mm", "5.2 mm"]
motion = { slider = { axis = [0, 0, 1], mass = "33.4 mg" } }

[scene.materials.stone]
density = "1000 kg/m3"

[[scene.bodies]]
name = "a ball"
density = "1000 kg/m3"
material = "stone"
spheres = [{ position = ["26 mm", "5.1 mm", "5.2 mm"], diameter = "4 mm" }]

[[scene.bodies]]
name = "pair"
density = "1000 kg/m3"
material = "stone"
clump = "dumbbell"
spheres = [{ position = ["32 mm", "5 mm", "5 mm"], diameter = "2 mm" }, { position = ["34 mm", "5 mm", "5 mm"], diameter = "2 mm" }]

[[scene.contacts]]
normal_stiffness = "500 N/m"
tangential_stiffness = "400 N/m"
friction = 0.3
restitution = 0.5

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.5 mm"

[outputs]
record = false
"#;

#[test]
fn forces_of_the_fluid_mean_the_same_on_all_that_it_touches() {
    let ran = run_text(RESTING, &[]).succeeded();
    let signals = ran.signals();
    let last = |name: &str| *signals[name].last().unwrap_or_else(|| panic!("{name}"));
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 8e-9 * 1000.0 * 9.81;
    for (name, expected) in [
        ("fluid.fixed.force_z", ball),
        ("fluid.held.force_z", ball),
        ("fluid.slides.force_z", ball),
        ("grains.slides.fluid_force", ball),
        ("grains.a_ball.fluid_force_z", ball),
        ("grains.dumbbell.fluid_force_z", ball / 4.0),
    ] {
        assert!((last(name) / expected - 1.0).abs() < 0.02, "{name}: {} {expected}", last(name));
    }
    assert!((last("grains.dumbbell.x") - 33e-3).abs() < 1e-6, "{}", last("grains.dumbbell.x"));
    assert!((last("grains.held.z") - 5.2e-3).abs() < 1e-12 && last("grains.held.wx") == 0.0);
    assert_eq!((last("grains.a_ball.qw"), last("fluid.x_lower.wall_force_y")), (1.0, 0.0));
    let all = &ran.summary()["signals"];
    let fixed = all["fluid.fixed.force_z"]["meaning"].as_str().unwrap().to_string();
    assert_eq!(all["fluid.slides.force_z"]["meaning"], fixed);
    assert!(fixed.contains("buoyancy") && fixed.contains("gaps"), "{fixed}");
}
