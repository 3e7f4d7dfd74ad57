//! The particle fluid in whole runs: free surfaces, plane scenes, bodies, and what it refuses.

use crate::tremie::{Ran, run, run_text, tremie};

/// A plane scene that takes a second: water collapses onto two cylinders.
const PLANE: &str = r#"
[run]
until = "60 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["80 mm", "20 mm", "60 mm"]
across = "y"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 mPa s"
fill = [{ max = ["30 mm", "20 mm", "40 mm"] }]

[[scene.bodies]]
name = "cylinders"
density = "800 kg/m3"
cylinders = [
    { position = ["45 mm", "3 mm", "5 mm"], diameter = "10 mm" },
    { position = ["60 mm", "0 mm", "5 mm"], diameter = "10 mm" },
]

[[scene.contacts]]
normal_stiffness = "10 kN/m"
tangential_stiffness = "8 kN/m"
friction = 0.3
restitution = 0.5

[components]
fluid = "fluid-pic"
grains = "grains-dem"

[settings.fluid-pic]
cell = "1 mm"

[settings.fluid-lbm]
cell = "2 mm"

[outputs]
signals = "2 ms"
record = false
"#;

#[test]
fn a_dam_break_runs_around_a_post_and_keeps_its_volume() {
    let ran = run("examples/dam-break/short.toml", &["--set", "outputs.frames=50 ms"]).succeeded();
    let signals = ran.signals();
    let last = |name: &str| *signals[name].last().unwrap();
    assert!(last("fluid.farthest_x") > 0.9, "the wave did not pass the post");
    assert!(signals["fluid.volume_drift"].iter().all(|drift| *drift < 0.03));
    assert!(signals["fluid.post.force_x"].iter().copied().fold(0.0, f64::max) > 1.0);
    // Nothing gives the fluid energy.
    let energy: Vec<f64> = (signals["fluid.kinetic_energy"].iter())
        .zip(&signals["fluid.potential_energy"])
        .map(|(kinetic, potential)| kinetic + potential)
        .collect();
    assert!(energy.iter().all(|e| *e < 1.02 * energy[0]), "{energy:?}");
}

#[test]
fn a_plane_scene_is_the_same_however_it_is_run() {
    let once = run_text(PLANE, &[]).succeeded();
    let signals = once.signals();
    assert!(signals["grains.mean_x"].last().unwrap() > &(signals["grains.mean_x"][0] + 1e-3));
    // In the plane, at the middle of its depth, whatever the manifest said.
    assert!(signals["grains.mean_y"].iter().all(|y| *y == 0.01));
    assert!(signals["grains.momentum_y"].iter().all(|p| *p == 0.0));
    let bits = |options: &[&str]| run_text(PLANE, options).succeeded().signals_text();
    let threads =
        |n: &str| format!("components.fluid={{ program = \"fluid-pic\", threads = {n} }}");
    assert!(bits(&["--in-process"]) == once.signals_text());
    assert!(bits(&["--set", &threads("1")]) == once.signals_text());
    assert!(bits(&["--set", &threads("2")]) == once.signals_text());
    let watched = ["--set", "outputs.record=true", "--set", "outputs.fields=20 ms"];
    assert!(bits(&watched) == once.signals_text());
}

/// Water at rest presses on its tank by its weight, and on a cylinder that floats by the
/// cylinder's.
#[test]
fn still_water_carries_what_floats_in_it() {
    let still = PLANE
        .replace("max = [\"30 mm\", \"20 mm\", \"40 mm\"]", "level = \"30 mm\"")
        .replace("\"45 mm\", \"3 mm\", \"5 mm\"", "\"25 mm\", \"3 mm\", \"27 mm\"")
        .replace("\"60 mm\", \"0 mm\", \"5 mm\"", "\"55 mm\", \"0 mm\", \"27 mm\"")
        .replace("until = \"60 ms\"", "until = \"0.5 s\"");
    let signals = run_text(&still, &[]).succeeded().signals();
    let late: Vec<usize> =
        (0..signals["time"].len()).filter(|&k| signals["time"][k] > 0.25).collect();
    let mean = |name: &str| late.iter().map(|&k| signals[name][k]).sum::<f64>() / late.len() as f64;
    let weight = 2.0 * 800.0 * std::f64::consts::PI * 5e-3_f64.powi(2) * 0.02 * 9.81;
    assert!((mean("fluid.body_force_z") / weight - 1.0).abs() < 0.02, "{weight}");
    let water = mean("fluid.particles") * 1000.0 * 1e-6 / 4.0 * 0.02 * 9.81;
    let floor = -mean("fluid.z_lower.wall_force_z");
    assert!((floor / (water + weight) - 1.0).abs() < 0.01, "{floor} {water} {weight}");
}

#[test]
fn another_fluid_takes_the_lattices_place_by_one_line() {
    let manifest = std::fs::read_to_string("examples/settling-sphere/short.toml").unwrap();
    let swapped = manifest.replacen("fluid = \"fluid-lbm\"", "fluid = \"fluid-pic\"", 1);
    let changed = manifest.lines().zip(swapped.lines()).filter(|(a, b)| a != b).count();
    assert_eq!(changed, 1);
    let speed = |text: &str| {
        let ran = run_text(text, &["--until", "0.15 s"]).succeeded();
        *ran.signals()["grains.body0_vz"].last().unwrap()
    };
    let (lattice, particles) = (speed(&manifest), speed(&swapped));
    // With 7.5 cells across the sphere each of them is some per cent off.
    assert!((particles / lattice - 1.0).abs() < 0.1, "{particles} {lattice} m/s");
}

#[test]
fn the_particle_fluid_conforms() {
    let output = tremie().args(["conform", "fluid-pic"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
}

/// What a run of the plane scene says after a change of its text.
#[track_caller]
fn refused(from: &str, to: &str) -> String {
    assert!(PLANE.contains(from), "{from}");
    let ran: Ran = run_text(&PLANE.replace(from, to), &[]);
    assert!(!ran.output.status.success(), "{to} passed");
    ran.errors()
}

#[test]
fn what_cannot_be_is_told_at_its_key() {
    let fill = "fill = [{ max = [\"30 mm\", \"20 mm\", \"40 mm\"] }]";
    let size = "size = [\"80 mm\", \"20 mm\", \"60 mm\"]\nacross = \"y\"";
    let faces = |face: &str| format!("{size}\nx = {face}");
    for (from, to, words) in [
        (fill, "fill = [{}]", ["scene.fluid.fill[0]", "found no region"]),
        (fill, "fill = [{ level = \"-1 mm\" }]", ["fill[0].level", "a level above it"]),
        (fill, "fill = [{ part = \"tank\" }]", ["fill[0].part", "\"tank\""]),
        (fill, "fill = [{ min = [\"90 mm\", \"0 mm\", \"0 mm\"] }]", ["fill[0]", "holds no point"]),
        (
            fill,
            "fill = [{ max = [\"0.2 mm\", \"20 mm\", \"40 mm\"] }]",
            ["fill[0]", "hold no water"],
        ),
        ("\"-9.81 m/s2\"]", "\"0 m/s2\"]", ["expected_speed", "how long a time step"]),
        ("cylinders = [", "spheres = [", ["scene.bodies[0].spheres", "where bodies are cylinders"]),
        (size, "size = [\"80 mm\", \"20 mm\", \"60 mm\"]", ["cylinders", "no plane scene"]),
        ("cell = \"1 mm\"", "cell = \"1 nm\"", ["cell", "take a larger cell"]),
        ("cell = \"1 mm\"", "cell = \"7 mm\"", ["cell", "whole number"]),
        ("cell = \"1 mm\"", "cell = \"1 mm\"\ncourant = 3.0", ["courant", "from 0.01 to 1"]),
        ("cell = \"1 mm\"", "cell = \"1 mm\"\ntransfer = \"flop\"", ["transfer", "flop"]),
        ("fluid = \"fluid-pic\"", "fluid = \"fluid-lbm\"", ["fluid-pic", "no free surface"]),
        (
            size,
            &faces("{ lower = { velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] } }"),
            ["scene.domain.x.lower.level", "how high the fluid stands"],
        ),
        (
            size,
            &faces(
                "{ upper = { pressure = \"0 Pa\", outflow = \"convective\", level = \"1 cm\" } }",
            ),
            ["scene.domain.x.upper", "has a convective outflow"],
        ),
        (
            size,
            &faces(
                "{ upper = { wall = { velocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"] }, level = \"1 cm\" } }",
            ),
            ["scene.domain.x.upper.level", "a face that is closed"],
        ),
        (
            fill,
            "[scene.domain.x]\nupper = { pressure = \"0 Pa\", level = \"1 cm\" }",
            ["scene.domain.x.upper.level", "the fluid fills its space"],
        ),
        (
            "cell = \"1 mm\"",
            "cell = \"1 mm\"\ngap_damping = { beta = 2.0 }",
            ["gap_damping.beta", "from 0 to 1"],
        ),
    ] {
        let errors = refused(from, to);
        for word in words {
            assert!(errors.contains(word), "{to}: expected \"{word}\" in: {errors}");
        }
    }
}

/// Two bodies that contact brings into one cell, and water shut in below a piston of cylinders, are
/// no reason to fail.
#[test]
fn bodies_may_share_cells() {
    let close = PLANE.replace("[\"60 mm\", \"0 mm\", \"5 mm\"]", "[\"55 mm\", \"0 mm\", \"5 mm\"]");
    run_text(&close, &[]).succeeded();
}

/// Water stands behind a gate until the gate goes, and runs out then: nothing is left of it in the
/// grid.
#[test]
fn a_gate_that_leaves_lets_the_water_go() {
    let gate = r#"
[[scene.parts]]
name = "gate"
box = { size = ["3 mm", "20 mm", "58 mm"] }
position = ["31.5 mm", "10 mm", "29 mm"]
motion = "prescribed"
course = [
    { time = "0 s" },
    { time = "29 ms" },
    { time = "30 ms", velocity = ["0 m/s", "0 m/s", "2 m/s"] },
    { time = "80 ms", velocity = ["0 m/s", "0 m/s", "2 m/s"] },
]
"#;
    let bodies = PLANE.find("[[scene.bodies]]").unwrap();
    let contacts = PLANE.find("[components]").unwrap();
    let scene = format!("{}{gate}{}", &PLANE[..bodies], &PLANE[contacts..])
        .replace("until = \"60 ms\"", "until = \"120 ms\"");
    let ran = run_text(&scene, &[]).succeeded();
    let signals = ran.signals();
    let front = &signals["fluid.farthest_x"];
    let at = |time: f64| signals["time"].iter().position(|t| *t >= time).unwrap();
    assert!(front[..at(0.028)].iter().all(|x| *x < 0.0301), "the gate leaked: {front:?}");
    assert!(front[at(0.1)] > 0.06, "the gate held the water: {front:?}");
    // While it stands the water presses on it by rho g H^2/2 of a depth of 20 mm.
    let force = signals["fluid.gate.force_x"][at(0.02)];
    assert!((force / (0.5 * 9810.0 * 0.04 * 0.04 * 0.02) - 1.0).abs() < 0.05, "{force} N");
    assert!(*signals["fluid.gate.force_x"].last().unwrap() == 0.0);
}

/// A channel with a stream: what enters leaves, also with two threads, and the level stays.
#[test]
fn a_stream_with_a_free_surface_passes_a_sill() {
    let scene = r#"
[run]
until = "1.2 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["600 mm", "50 mm", "160 mm"]
across = "y"

[scene.domain.x]
lower = { velocity = ["0.3 m/s", "0 m/s", "0 m/s"], level = "100 mm" }
upper = { pressure = "0 Pa", level = "100 mm", absorbing = true }

[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 mPa s"
velocity = ["0.3 m/s", "0 m/s", "0 m/s"]
fill = [{ level = "100 mm" }]

[[scene.parts]]
name = "sill"
box = { size = ["50 mm", "50 mm", "40 mm"] }
position = ["225 mm", "25 mm", "20 mm"]

[components]
fluid = "fluid-pic"

[settings.fluid-pic]
cell = "5 mm"

[outputs]
signals = "10 ms"
record = false
"#;
    let ran = run_text(scene, &[]).succeeded();
    let signals = ran.signals();
    let last = |name: &str| *signals[name].last().unwrap();
    let exact = 0.3 * 0.1 * 0.05 * 1.2;
    assert!((last("fluid.volume_entered") / exact - 1.0).abs() < 0.02);
    // The sill lifts the level before it first, by some of what enters.
    let left = last("fluid.volume_left") / exact;
    assert!((0.5..1.02).contains(&left), "{left}");
    assert!(signals["fluid.volume_drift"].iter().all(|drift| *drift < 0.01));
    // No jets come out of the corners of the sill.
    assert!(signals["fluid.max_speed"].iter().all(|speed| *speed < 2.0));
    let other = run_text(scene, &["--in-process"]).succeeded().signals_text();
    assert!(other == ran.signals_text());
}

/// A slope that wraps around: water and cylinders run down it for ever, in the fluid's own pace.
#[test]
fn a_periodic_axis_joins_its_ends() {
    let periodic = PLANE
        .replace("across = \"y\"", "across = \"y\"\nx = \"periodic\"")
        .replace("\"0 m/s2\", \"0 m/s2\", \"-9.81", "\"2 m/s2\", \"0 m/s2\", \"-9.81")
        .replace("until = \"60 ms\"", "until = \"300 ms\"");
    let ran = run_text(&periodic, &[]).succeeded();
    let signals = ran.signals();
    let mass =
        1000.0 * 0.03 * 0.04 * 0.02 + 2.0 * 800.0 * 0.25 * std::f64::consts::PI * 1e-4 * 0.02;
    let momentum =
        signals["fluid.momentum_x"].last().unwrap() + signals["grains.momentum_x"].last().unwrap();
    // Slip along the floor; friction of the cylinders holds back what they weigh in the water.
    let free = mass * 2.0 * signals["time"].last().unwrap();
    assert!(momentum > 0.5 * free && momentum < 1.02 * free, "{momentum} {free}");
    assert!(signals["fluid.volume_drift"].iter().all(|drift| *drift < 0.05));
    let other = run_text(&periodic, &["--in-process"]).succeeded().signals_text();
    assert!(other == ran.signals_text());
}
