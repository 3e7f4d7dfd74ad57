//! Parts that slide on a spring.

use crate::tremie::run_text;

/// A valve closes on its stop; nothing else is there.
const DRY: &str = r#"
[run]
until = "5 ms"

[scene.domain]
size = ["20 mm", "20 mm", "20 mm"]

[[scene.parts]]
name = "valve"
cylinder = { radius = "5 mm", length = "2 mm" }
position = ["10 mm", "10 mm", "10 mm"]

[scene.parts.motion.slider]
axis = [0, 0, 1]
mass = "9.2 g"
lift = "1 mm"
spring = { rate = "625 N/m", preload = "92 mm", stroke = "4.5 mm" }
stops = { lower = "0 mm", upper = "4.5 mm", stiffness = "1e7 N/m", restitution = 0.2 }

[components]
grains = "grains-dem"
"#;

/// A plate in a duct: the fluid that passes it holds it against a spring.
const HELD: &str = r#"
[run]
until = "0.8 s"

[scene.domain]
size = ["12 mm", "12 mm", "24 mm"]
z = { lower = { pressure = "40 Pa", ramp = "50 ms" }, upper = { pressure = "0 Pa" } }

[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.1 Pa s"
expected_speed = "80 mm/s"

[[scene.parts]]
name = "plate"
box = { size = ["8 mm", "8 mm", "2 mm"] }
position = ["6 mm", "6 mm", "10 mm"]
motion = { slider = { axis = [0, 0, 1], mass = "1 g", spring = { rate = "2 N/m", preload = "1e-3 N" } } }

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "1 mm"
"#;

#[test]
fn a_valve_closes_and_its_signals_say_how_it_is_held() {
    let ran = run_text(DRY, &["--set", "outputs.record=false"]).succeeded();
    let signals = ran.signals();
    let last = |name: &str| *signals[&format!("grains.valve.{name}")].last().unwrap();
    assert!((last("lift") / -5.75e-6 - 1.0).abs() < 1e-3, "{}", last("lift"));
    assert!((last("spring_force") + 57.5).abs() < 0.01, "{}", last("spring_force"));
    assert!((last("stop_force") - 57.5).abs() < 0.01, "{}", last("stop_force"));
    assert_eq!((last("contact_force"), last("fluid_force")), (0.0, 0.0));
    assert!(last("velocity").abs() < 1e-4, "{}", last("velocity"));
    assert_eq!(last("force_z"), 0.0);
}

#[test]
fn a_flow_holds_a_plate_against_its_spring() {
    let ran = run_text(HELD, &["--set", "outputs.record=false"]).succeeded();
    let signals = ran.signals();
    let last = |name: &str| *signals[&format!("grains.plate.{name}")].last().unwrap();
    let (fluid, spring, lift) = (last("fluid_force"), last("spring_force"), last("lift"));
    assert!(fluid > 1.5e-3, "{fluid}");
    assert!((fluid + spring).abs() < 0.01 * fluid, "{fluid} {spring}");
    assert!((spring + 1e-3 + 2.0 * lift).abs() < 1e-9, "{spring} {lift}");
}
