//! One physics without the other.

use crate::tremie::run_text;

const FLUID: &str = r#"
[run]
until = "0.2 s"

[scene.domain]
size = ["4 mm", "4 mm", "8 mm"]
y = "periodic"
z = "periodic"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
acceleration = ["0 m/s2", "0 m/s2", "1 m/s2"]

[components]
fluid = "fluid-lbm"

[settings.fluid-lbm]
cell = "0.5 mm"

[outputs]
frames = "50 ms"
"#;

const GRAINS: &str = r#"
[run]
until = "100 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-10 m/s2"]

[scene.domain]
size = ["10 mm", "10 mm", "100 mm"]

[[scene.bodies]]
name = "ball"
density = "2500 kg/m3"
spheres = [{ position = ["5 mm", "5 mm", "80 mm"], diameter = "4 mm" }]

[[scene.contacts]]
normal_stiffness = "100 N/m"
tangential_stiffness = "80 N/m"
friction = 0.3
restitution = 0.5

[components]
grains = "grains-dem"
"#;

#[test]
fn a_fluid_flows_without_grains() {
    let ran = run_text(FLUID, &[]).succeeded();
    let speed = &ran.signals()["fluid.max_speed"];
    // Between plates 4 mm apart, driven by 1 m/s2: g h^2 / (8 nu) = 0.04 m/s in the end, and at the
    // cells next to the middle, 3.5 of 8 cells from a plate, 4 s (1 - s) of it.
    let [middle, last] = [0.04 * 4.0 * 3.5 / 8.0 * 4.5 / 8.0, *speed.last().unwrap()];
    assert!((last / middle - 1.0).abs() < 0.005, "{last} m/s, expected {middle}");
    assert!(ran.out.join("run.mcap").exists());
}

#[test]
fn grains_fall_without_a_fluid() {
    let ran = run_text(GRAINS, &["--set", "outputs.record=false"]).succeeded();
    let height = ran.signals()["grains.body0_z"].last().copied().unwrap();
    let time = ran.summary()["simulated_time"].as_f64().unwrap();
    assert!((height - (0.08 - 5.0 * time * time)).abs() < 1e-12, "{height} m");
}
