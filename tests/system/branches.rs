//! Runs that begin from a checkpoint of another, and changes that hold from there on.

use crate::tremie::{Ran, SMALL, run_text};

/// A piston that drives a fluid past a paddle and a grain on the floor.
const CHANNEL: &str = r#"
[run]
until = "40 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["20 mm", "10 mm", "10 mm"]
[scene.domain.x.lower.reservoir]
area = "1 cm2"
volume = "10 mL"
piston = "0.02 m/s"
[scene.domain.x.upper]
pressure = "0 Pa"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
expected_speed = "0.1 m/s"

[[scene.parts]]
name = "paddle"
box = { size = ["3 mm", "3 mm", "3 mm"] }
position = ["7 mm", "5 mm", "4 mm"]
motion = "prescribed"
velocity = ["0 m/s", "0 m/s", "0.02 m/s"]

[[scene.bodies]]
name = "grain"
density = "2500 kg/m3"
spheres = [{ position = ["14 mm", "5 mm", "2.001 mm"], diameter = "4 mm", velocity = ["0.01 m/s", "0 m/s", "0 m/s"] }]

[[scene.contacts]]
normal_stiffness = "50 N/m"
tangential_stiffness = "40 N/m"
friction = 0.3
restitution = 0.5

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "1 mm"
time_step = "0.1 ms"

[outputs]
record = false
"#;

/// Window of the checkpoint.
const KEPT: u64 = 40;

fn first_run() -> Ran {
    let every = format!("run.checkpoints={{ windows = {KEPT}, keep = 9 }}");
    run_text(CHANNEL, &["--quiet", "--set", &every]).succeeded()
}

/// A run that begins from the first one's checkpoint.
fn branch(first: &Ran, options: &[&str]) -> Ran {
    let from = format!("{}@{KEPT}", first.out.display());
    run_text(CHANNEL, &[&["--quiet", "--from", &from][..], options].concat())
}

/// Rows of a table of signals after the header.
fn rows(ran: &Ran) -> Vec<String> {
    ran.signals_text().lines().skip(1).map(str::to_string).collect()
}

#[test]
fn a_run_begins_from_the_state_of_another() {
    let first = first_run();
    let recorded = ["--set", "outputs.record=true", "--in-process"];
    for options in [&[][..], &recorded] {
        let ran = branch(&first, options).succeeded();
        assert_eq!(rows(&ran), rows(&first)[KEPT as usize + 1..]);
        assert_eq!(ran.summary()["windows"], first.summary()["windows"]);
        assert_eq!(ran.out.join("run.mcap").exists(), !options.is_empty());
    }
    // The first run is as it was.
    assert!(first.out.join("summary.json").exists());
    assert!(first.out.join("checkpoints/window-000000000040").is_dir());
}

#[test]
fn what_drives_a_run_may_change() {
    let first = first_run();
    // A signal that feels the change first, and whether the change makes it larger.
    for (change, signal, is_larger) in [
        ("scene.gravity[0]=3 m/s2", "grains.momentum_x", true),
        ("scene.fluid.acceleration=[\"1 m/s2\", \"0 m/s2\", \"0 m/s2\"]", "fluid.momentum_x", true),
        ("scene.domain.x.lower.reservoir.piston=0.03 m/s", "fluid.momentum_x", true),
        ("scene.domain.x.lower.reservoir.stop=1 ms", "fluid.momentum_x", false),
        ("scene.domain.x.upper.pressure=20 Pa", "fluid.momentum_x", false),
        ("scene.parts[0].velocity[2]=0.01 m/s", "fluid.paddle.force_z", true),
        ("scene.contacts[0].friction=0.01", "grains.momentum_x", true),
        ("scene.fluid.viscosity=0.1 Pa s", "fluid.reservoir_x_lower.pressure", true),
    ] {
        let ran = branch(&first, &["--set", change]).succeeded();
        let (before, after) = (first.signals(), ran.signals());
        let row = 60;
        let (one, other) = (before[signal][KEPT as usize + 1 + row], after[signal][row]);
        assert_eq!(other > one, is_larger, "{change}: {signal} {one} {other}");
        // The fluid does not jump in the first window: its state goes on.
        let flow = &before["fluid.momentum_x"];
        let (one, other) = (flow[KEPT as usize + 1], after["fluid.momentum_x"][0]);
        assert!((other - one).abs() < 0.05 * one.abs(), "{change}: {one} {other}");
    }
}

#[test]
fn a_state_that_does_not_fit_is_refused_by_name() {
    let first = first_run();
    for (options, why) in [
        (["--set", "scene.domain.size[1]=12 mm"], "scene.domain.size[1] cannot change"),
        (["--set", "settings.fluid-lbm.time_step=0.05 ms"], "time_step cannot change"),
        (["--set", "scene.contacts[0].normal_stiffness=80 N/m"], "normal_stiffness cannot change"),
        (["--until", "5 ms"], "make it longer"),
    ] {
        let ran = branch(&first, &options);
        assert!(ran.errors().contains(why), "{}", ran.errors());
        assert!(!ran.out.join("summary.json").exists() && ran.code() != Some(0));
    }
    for (from, why) in [
        (format!("{}@7", first.out.display()), "holds no checkpoint of window 7"),
        ("nowhere@40".into(), "holds no checkpoint"),
        ("nowhere@soon".into(), "is no window"),
    ] {
        let ran = run_text(CHANNEL, &["--quiet", "--from", &from]);
        assert_eq!(ran.code(), Some(2));
        assert!(ran.errors().contains(why), "{}", ran.errors());
    }
}

/// [`SMALL`] without its fluid.
fn dry() -> String {
    let fluid = "[scene.fluid]\ndensity = \"1000 kg/m3\"\nviscosity = \"0.05 Pa s\"\n\n";
    let settings = "[settings.fluid-lbm]\ncell = \"0.5 mm\"\n\n";
    let wet = [fluid, "fluid = \"fluid-lbm\"\n", settings];
    let dry = wet.iter().fold(SMALL.to_string(), |text, wet| text.replace(wet, ""));
    assert!(!dry.contains("fluid"), "{dry}");
    dry
}

/// Places and velocities of the grains in a row of signals.
fn grains_in(ran: &Ran, row: usize) -> Vec<f64> {
    let signals = ran.signals();
    let of = |body: usize| {
        ["x", "y", "z", "vx", "vy", "vz"]
            .map(|name| signals[&format!("grains.body{body}_{name}")][row])
    };
    (0..3).flat_map(of).collect()
}

#[test]
fn a_bed_that_settled_dry_is_poured_over() {
    let window = 4000;
    let keep = format!("run.checkpoints={{ windows = {window}, keep = 1 }}");
    let bed = run_text(&dry(), &["--quiet", "--until", "0.4 s", "--set", &keep]).succeeded();
    let from = format!("{}@{window}", bed.out.display());
    let poured = |text: &str, options: &[&str]| {
        run_text(text, &[&["--quiet", "--until", "5 ms", "--from", &from], options].concat())
    };
    let wet = poured(SMALL, &[]).succeeded();
    // Where the dry grains were, and at time zero.
    assert_eq!(grains_in(&wet, 0), grains_in(&bed, window));
    assert_eq!(wet.signals()["time"][0], 0.0);
    let log = std::fs::read_to_string(wet.out.join("log.jsonl")).unwrap();
    assert!(log.contains("begins at time zero with the bodies of"), "{log}");
    // The fluid knows all of them, and carries its share of their weight.
    let weight =
        9.81 * 2500.0 * std::f64::consts::PI / 6.0 * (2.0 * 3e-3_f64.powi(3) + 4e-3_f64.powi(3));
    let share = wet.signals()["grains.impulse_received_z"].last().unwrap() / 5e-3 / weight;
    assert!((0.3..0.5).contains(&share), "{share}");
    // Another fluid, in parallel, in one process; the same bits on another number of threads.
    let other = SMALL.replace("fluid-lbm", "fluid-pic");
    for (text, options) in [
        (SMALL, &["--set", "components.grains.threads=1", "--in-process"][..]),
        (&other, &["--schedule", "parallel"]),
    ] {
        let ran = poured(text, options).succeeded();
        assert_eq!(grains_in(&ran, 0), grains_in(&bed, window));
        assert_eq!(text == SMALL, ran.signals_text() == wet.signals_text());
    }
}

#[test]
fn bodies_that_a_run_cannot_begin_with_are_refused_by_name() {
    let keep = ["--quiet", "--set", "run.checkpoints={ windows = 100, keep = 1 }"];
    let bed = run_text(&dry(), &keep).succeeded();
    let bed = bed.out.display().to_string();
    let hard = SMALL.replace("grains-dem", "grains-hard-sphere");
    for (text, change, why) in [
        (
            SMALL,
            "scene.bodies[0].density=2600 kg/m3",
            "scene.bodies[0].density must be as in the run",
        ),
        (SMALL, "scene.domain.size[0]=13 mm", "scene.domain.size[0] must be as in the run"),
        (SMALL, "scene.domain.x=periodic", "scene.domain.x must be as in the run"),
        (SMALL, "settings.grains-dem.skin=0.3", "settings.grains-dem"),
        (&hard, "run.seed=2", "no grains of the same name and program"),
    ] {
        let ran = run_text(text, &["--quiet", "--from", &bed, "--set", change]);
        assert!(ran.errors().contains(why), "{change}: {}", ran.errors());
        assert!(ran.code() == Some(2) && !ran.out.exists(), "{change}");
    }
}
