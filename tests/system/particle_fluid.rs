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
        (size, &faces("\"periodic\""), ["x_lower", "is periodic"]),
        (
            size,
            &faces("{ lower = { velocity = [\"1 m/s\", \"0 m/s\", \"0 m/s\"] } }"),
            ["x_lower", "has a velocity"],
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
