//! Hard spheres in whole runs: in the place of discrete elements by one line, and what `check` says.

use crate::tremie::{Ran, run_text, tremie};

/// The manifest with hard spheres for its grains: one line differs.
fn swapped(path: &str) -> [String; 2] {
    let soft = std::fs::read_to_string(path).unwrap();
    let hard = soft.replacen("grains = \"grains-dem\"", "grains = \"grains-hard-sphere\"", 1);
    assert_eq!(soft.lines().zip(hard.lines()).filter(|(a, b)| a != b).count(), 1);
    [soft, hard]
}

/// The exit code of `tremie check`, and what it says.
fn check(text: &str) -> (Option<i32>, String) {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let output = tremie().arg("check").arg(&manifest).output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8_lossy(&said).into_owned())
}

/// The suspension sinks as fast with either grains while they are dilute.
#[test]
fn a_suspension_settles_with_either_grains() {
    let fall = |text: &str| {
        let ran = run_text(text, &["--until", "40 ms"]).succeeded();
        let height = ran.signals()["grains.mean_height"].clone();
        height[0] - height.last().unwrap()
    };
    let [soft, hard] = swapped("examples/suspension/short.toml").map(|text| fall(&text));
    assert!(soft > 0.0 && (hard / soft - 1.0).abs() < 0.1, "{hard} m, {soft} m");
}

/// Two discs that settle one behind the other: up to their touch nothing depends on the contact.
#[test]
fn two_discs_draft_with_either_grains() {
    let run = |text: &str| -> Ran { run_text(text, &["--until", "0.2 s"]).succeeded() };
    let [soft, hard] = swapped("tests/validation/two-discs-settling/manifest.toml")
        .map(|text| run(&text).signals());
    for signal in ["grains.body0_z", "grains.body1_z"] {
        let way = |of: &[f64]| of[0] - of.last().unwrap();
        let (soft, hard) = (way(&soft[signal]), way(&hard[signal]));
        assert!(soft > 1e-3 && (hard / soft - 1.0).abs() < 0.03, "{signal}: {hard} m, {soft} m");
    }
}

/// A dry gas of hard spheres, from event to event.
pub const GAS: &str = r#"
[run]
until = "0.2 s"

[scene]

[scene.domain]
size = ["20 mm", "20 mm", "20 mm"]
x = "periodic"
y = "periodic"

[[scene.bodies]]
name = "gas"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "0 mm"], max = ["20 mm", "20 mm", "20 mm"], fraction = 0.1, diameter = ["1.6 mm", "2 mm"], seed = 1 }

[[scene.bodies]]
name = "fast"
density = "2500 kg/m3"
spheres = [{ position = ["10 mm", "10 mm", "10 mm"], diameter = "2 mm", velocity = ["2 m/s", "1 m/s", "0.5 m/s"] }]

[[scene.contacts]]
normal_stiffness = "1 kN/m"
tangential_stiffness = "0.8 kN/m"
friction = 0.2
restitution = 0.95

[components]
grains = "grains-hard-sphere"

[outputs]
signals = "20 ms"
record = false
"#;

#[test]
fn a_dry_gas_is_the_same_however_it_is_run() {
    let once = run_text(GAS, &[]).succeeded();
    let signals = once.signals();
    assert!(signals["grains.collisions"].last().unwrap() > &100.0);
    let bits = |options: &[&str]| run_text(GAS, options).succeeded().signals_text();
    assert!(bits(&["--in-process"]) == once.signals_text());
    let threads = |n: &str| {
        format!("components.grains={{ program = \"grains-hard-sphere\", threads = {n} }}")
    };
    for n in ["1", "2", "8"] {
        assert!(bits(&["--set", &threads(n)]) == once.signals_text(), "{n} threads");
    }
    let by_steps = ["--set", "settings.grains-hard-sphere.detection=\"steps\""];
    let steps = run_text(GAS, &by_steps).succeeded();
    let with = |n: &str| {
        let threads = threads(n);
        bits(&[by_steps[0], by_steps[1], "--set", &threads])
    };
    assert!(with("1") == steps.signals_text() && with("2") == steps.signals_text());
}

#[test]
fn check_says_what_is_too_dense_and_what_hard_spheres_cannot_do() {
    let dense = GAS.replace("fraction = 0.1", "fraction = 0.62");
    let (code, said) = check(&dense);
    assert!(said.contains("too dense for hard spheres") && said.contains("grains-dem"), "{said}");
    assert_ne!(code, Some(0), "{said}");
    let rolling = GAS.replace("friction = 0.2", "friction = 0.2\nrolling_friction = 0.1");
    let (code, said) = check(&rolling);
    assert_ne!(code, Some(0), "{said}");
    for words in ["rolling_friction", "is 0.1, expected 0", "grains-dem"] {
        assert!(said.contains(words), "expected \"{words}\" in: {said}");
    }
    let (code, said) = check(GAS);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("from event to event"), "{said}");
}
