//! Every example, in its short form.

use crate::tremie::run;

#[test]
fn settling_sphere() {
    let ran = run("examples/settling-sphere/short.toml", &[]).succeeded();
    let signals = ran.signals();
    let z = &signals["grains.body0_z"];
    assert!(z.last().unwrap() < &z[0], "the sphere rises");
    let speed = ran.summary()["signals"]["grains.max_speed"]["max"].as_f64().unwrap();
    assert!((0.05..0.13).contains(&speed), "{speed} m/s");
}

#[test]
fn suspension() {
    let ran = run("examples/suspension/short.toml", &[]).succeeded();
    let height = &ran.signals()["grains.mean_height"];
    assert!(height.last().unwrap() < &height[0], "the grains rise");
}

#[test]
fn suspension_in_another_fluid_by_one_line() {
    let manifest = std::fs::read_to_string("examples/suspension/short.toml").unwrap();
    let swapped = manifest.replacen("fluid = \"fluid-lbm\"", "fluid = \"minimal-fluid\"", 1);
    let changed = manifest.lines().zip(swapped.lines()).filter(|(a, b)| a != b).count();
    assert_eq!(changed, 1);
    let ran = crate::tremie::run_text(&swapped, &["--until", "20 ms"]).succeeded();
    assert!(ran.signals()["fluid.largest_drag"].last().unwrap() > &0.0);
}
