//! Memory of a run: the number that `check` gives, and the sum that its processes take.

use crate::tremie::{SMALL, root, tremie};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

/// A large sphere beside many that are a sixtieth as wide.
const MIXED: &str = r#"
[run]
until = "0.005 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["20 mm", "20 mm", "40 mm"]

[[scene.bodies]]
name = "big"
density = "2500 kg/m3"
spheres = [{ position = ["10 mm", "10 mm", "10 mm"], diameter = "12 mm" }]

[[scene.bodies]]
name = "fine"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "18 mm"], max = ["20 mm", "20 mm", "23 mm"], fraction = 0.1, diameter = "0.2 mm", seed = 3 }

[[scene.contacts]]
normal_stiffness = "500 N/m"
tangential_stiffness = "400 N/m"
friction = 0.3
restitution = 0.5

[components]
grains = "grains-dem"

[outputs]
record = false
"#;

/// Processes that descend from one, itself first.
pub fn family(process: u32) -> Vec<u32> {
    let mut all = vec![process];
    let mut next = 0;
    while let Some(&process) = all.get(next) {
        next += 1;
        let tasks = fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten();
        for task in tasks {
            let children = fs::read_to_string(task.path().join("children")).unwrap_or_default();
            all.extend(children.split_whitespace().filter_map(|id| id.parse::<u32>().ok()));
        }
    }
    all
}

/// Largest resident set of a process so far [bytes].
fn resident(process: u32) -> Option<f64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024.0 * line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()?)
}

/// Memory of a run as `check` gives it, and the sum of the largest resident sets of its processes
/// [bytes].
fn told_and_taken(manifest: &Path, options: &[&str]) -> (f64, f64) {
    let told = tremie().args(["check", "--json"]).arg(manifest).args(options).output().unwrap();
    let said = String::from_utf8_lossy(&told.stdout);
    let events = said.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let plan = events.into_iter().find(|event| event["event"] == "plan").expect("a plan");
    let findings = plan["findings"].as_array().expect("findings");
    let of_run =
        |finding: &&Value| finding["component"] == "run" && finding["quantity"] == "memory";
    let told = findings.iter().find(of_run).expect("memory")["value"].as_f64().unwrap();
    let home = tempfile::tempdir().unwrap();
    let mut run = tremie();
    run.arg("run").arg(manifest).arg("--out").arg(home.path().join("out")).args(options);
    let mut child = run.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let mut largest = BTreeMap::new();
    while child.try_wait().unwrap().is_none() {
        for process in family(child.id()) {
            largest.extend(resident(process).map(|bytes| (process, bytes)));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!(child.wait().unwrap().success());
    // What was seen between a fork and the program's start is no process of the run.
    (told, largest.values().filter(|&&bytes| bytes > 5e6).sum())
}

/// A ball of 3 mm about the origin in 239,000 triangles, as binary STL in mm.
fn fine_ball() -> Vec<u8> {
    const ROUNDS: u32 = 600;
    const LAYERS: u32 = 200;
    let at = |layer: u32, k: u32| {
        let slope = std::f32::consts::PI * layer as f32 / LAYERS as f32;
        let angle = std::f32::consts::TAU * (k % ROUNDS) as f32 / ROUNDS as f32;
        let across = if layer.is_multiple_of(LAYERS) { 0.0 } else { slope.sin() };
        [across * angle.cos(), across * angle.sin(), slope.cos()].map(|x| 1.5 * x)
    };
    let mut triangles = Vec::new();
    for (layer, k) in (0..LAYERS).flat_map(|layer| (0..ROUNDS).map(move |k| (layer, k))) {
        let [a, b] = [at(layer, k), at(layer + 1, k)];
        let [c, d] = [at(layer + 1, k + 1), at(layer, k + 1)];
        if layer + 1 < LAYERS {
            triangles.push([a, b, c]);
        }
        if layer > 0 {
            triangles.push([a, c, d]);
        }
    }
    let mut file = vec![b' '; 80];
    file.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        let numbers = [[0.0; 3]].into_iter().chain(triangle).flatten();
        file.extend(numbers.flat_map(f32::to_le_bytes));
        file.extend([0, 0]);
    }
    file
}

/// A part of many triangles takes memory in every component that meets it.
#[test]
fn the_memory_of_triangles_is_told() {
    let home = tempfile::tempdir().unwrap();
    fs::write(home.path().join("ball.stl"), fine_ball()).unwrap();
    let manifest = home.path().join("manifest.toml");
    for motion in ["fixed", "prescribed"] {
        let part = format!(
            "[[scene.parts]]\nname = \"ball\"\nfile = \"ball.stl\"\nunit = \"mm\"\nmotion = \"{motion}\"\n\
             position = [\"9 mm\", \"3 mm\", \"3 mm\"]\n\n[[scene.contacts]]"
        );
        let text = SMALL.replace("0.02 s", "1 ms").replacen("[[scene.contacts]]", &part, 1);
        fs::write(&manifest, text).unwrap();
        let (told, taken) = told_and_taken(&manifest, &[]);
        assert!(taken > 1.5e8, "{motion}: most of {taken} is not the part's");
        assert!(told < 2.0 * taken && taken < 2.0 * told, "{motion}: {told} {taken}");
    }
}

#[test]
fn the_memory_that_is_told_is_what_a_run_takes() {
    let home = tempfile::tempdir().unwrap();
    let mixed = home.path().join("mixed.toml");
    fs::write(&mixed, MIXED).unwrap();
    let suspension = root().join("examples/suspension/manifest.toml");
    let dice = root().join("examples/dice/manifest.toml");
    let cases: [(&Path, &[&str]); 4] = [
        (&mixed, &[]),
        (&mixed, &["--set", "scene.bodies[1].packing.diameter=2 mm"]),
        (&suspension, &["--until", "2 ms"]),
        (&dice, &["--until", "1 ms"]),
    ];
    for (manifest, options) in cases {
        let (told, taken) = told_and_taken(manifest, options);
        println!(
            "{manifest:?} {options:?}: {:.1} MB told, {:.1} MB taken",
            1e-6 * told,
            1e-6 * taken
        );
        assert!(
            told < 2.0 * taken && taken < 2.0 * told,
            "{manifest:?} {options:?}: {told} {taken}"
        );
    }
}
