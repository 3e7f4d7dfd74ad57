//! Polyhedra in whole runs.

use crate::tremie::{run, run_text, tremie};

/// The example, as short as it takes the first dice to reach the plate.
const SHORT: &[&str] = &[
    "--until",
    "100 ms",
    "--set",
    "scene.contacts[0].normal_stiffness=2e4 N/m",
    "--set",
    "scene.contacts[0].tangential_stiffness=1.6e4 N/m",
];

#[test]
fn dice_fall_and_are_drawn_and_written_without_a_change_of_bits() {
    let alone = run("examples/dice", SHORT).succeeded();
    let signals = alone.signals();
    assert!(signals["grains.contacts"].iter().any(|&contacts| contacts > 0.0), "nothing fell");
    let height = &signals["grains.mean_height"];
    assert!(height.last().unwrap() + 10e-3 < height[0]);
    let options: Vec<&str> =
        SHORT.iter().copied().chain(["--in-process", "--set", "outputs.fields=20 ms"]).collect();
    let watched = run("examples/dice", &options).succeeded();
    assert!(watched.signals_text() == alone.signals_text(), "the observers changed the run");
    let fields = watched.out.join("fields");
    let series = std::fs::read_to_string(fields.join("polyhedra.pvd")).unwrap();
    assert!(series.matches("polyhedra_").count() >= 5, "{series}");
    let about = std::fs::read_to_string(fields.join("about.txt")).unwrap();
    for words in ["shape 0 = cube", "shape 2 = chip"] {
        assert!(about.contains(words), "expected \"{words}\" in: {about}");
    }
}

/// Errors of `check` on the example after a change of its text.
fn said(from: &str, to: &str) -> String {
    let manifest = std::fs::read_to_string("examples/dice/manifest.toml").unwrap();
    assert!(manifest.contains(from), "{from}");
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("manifest.toml");
    std::fs::write(&path, manifest.replacen(from, to, 1)).unwrap();
    let output = tremie().arg("check").arg(&path).output().unwrap();
    assert!(!output.status.success(), "{to} passed");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn what_polyhedra_cannot_be_is_told_at_its_line() {
    let fluid =
        "[scene.fluid]\ndensity = \"1000 kg/m3\"\nviscosity = \"0.1 Pa s\"\n\n[[scene.shapes]]";
    let with_fluid = "[components]\nfluid = \"minimal-fluid\"";
    let manifest = std::fs::read_to_string("examples/dice/manifest.toml").unwrap();
    let coupled =
        manifest.replacen("[[scene.shapes]]", fluid, 1).replacen("[components]", with_fluid, 1);
    let refused = run_text(&coupled, &["--until", "1 ms"]);
    assert!(!refused.output.status.success());
    assert!(refused.errors().contains("takes no polyhedra"), "{}", refused.errors());

    for (from, to, words) in [
        ("[0.8, 0.5, 1.1]", "[1.6, 1, 0.5]", ["scene.shapes[0].vertices", "inside the hull"]),
        (
            ", [0.4, 1.7, 0.3], [0.8, 0.5, 1.1], [1.9, 0.9, 1.2]]",
            "]",
            ["scene.shapes[0].vertices", "no shape"],
        ),
        ("shape = \"cube\"", "shape = \"cub\"", ["scene.bodies[0].shape", "octahedron"]),
        ("edge = \"20 mm\"", "size = \"20 mm\"", ["polyhedra[0]", "size"]),
        (
            "\"175 mm\"], edge = \"20 mm\"",
            "\"1 mm\"], edge = \"20 mm\"",
            ["scene.bodies[2]", "lower face in z"],
        ),
        (
            "\"175 mm\"], edge = \"20 mm\"",
            "\"60 mm\"], edge = \"20 mm\"",
            ["scene.bodies[2]", "part \"plate\""],
        ),
        (
            "[\"60 mm\", \"80 mm\", \"175 mm\"]",
            "[\"43 mm\", \"41 mm\", \"176 mm\"]",
            ["scene.bodies[2]", "overlap by"],
        ),
        (
            "shape = \"cube\"",
            "clump = \"tower\"\nshape = \"cube\"",
            ["scene.bodies[0].clump", "packed"],
        ),
        ("fraction = 0.12", "fraction = 0.3", ["scene.bodies[0].packing.fraction", "at most 0.2"]),
    ] {
        let said = said(from, to);
        for word in words {
            assert!(said.contains(word), "expected \"{word}\" in: {said}");
        }
    }
}

/// Dice, a ball and a clump of both sink in a liquid between two plates.
const SINKING: &str = r#"
[run]
until = "60 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["48 mm", "48 mm", "60 mm"]
x = "periodic"
y = "periodic"

[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 Pa s"

[[scene.bodies]]
name = "dice"
density = "2500 kg/m3"
shape = "cube"
polyhedra = [
    { position = ["15 mm", "15 mm", "11 mm"], edge = "12 mm", rotation = { axis = [1, 1, 0], angle = "40 deg" } },
    { position = ["40 mm", "30 mm", "40 mm"], edge = "12 mm" },
]

[[scene.bodies]]
name = "ball"
density = "2500 kg/m3"
spheres = [{ position = ["15 mm", "40 mm", "40 mm"], diameter = "15 mm" }]

[[scene.bodies]]
name = "head"
density = "2500 kg/m3"
material = "dice"
clump = "hammer"
shape = "cube"
polyhedra = [{ position = ["40 mm", "10 mm", "25 mm"], edge = "10 mm" }]

[[scene.bodies]]
name = "handle"
density = "2500 kg/m3"
material = "ball"
clump = "hammer"
spheres = [{ position = ["32 mm", "10 mm", "25 mm"], diameter = "10 mm" }]

[[scene.contacts]]
normal_stiffness = "1e4 N/m"
tangential_stiffness = "8e3 N/m"
friction = 0.4
restitution = 0.4

[components]
grains = "grains-dem"

[components.fluid]
program = "fluid-lbm"
threads = 1

[settings.fluid-lbm]
cell = "2 mm"

[outputs]
signals = "2 ms"
"#;

/// In processes and in one, on one thread and on two. The bodies are between weightless and falling
/// freely: it is the fluid that holds them.
#[test]
fn dice_sink_in_a_fluid_with_the_same_bits() {
    let alone = run_text(SINKING, &[]).succeeded();
    let together =
        run_text(SINKING, &["--in-process", "--set", "components.fluid.threads=2"]).succeeded();
    assert!(alone.signals_text() == together.signals_text(), "threads or processes enter the bits");
    let signals = alone.signals();
    let sunk = signals["grains.mean_height"][0] - signals["grains.mean_height"].last().unwrap();
    let free = 0.5 * 9.81 * 60e-3f64.powi(2);
    println!("sunk by {sunk} m; {free} m without a fluid");
    assert!(sunk > 0.02 * free && sunk < 0.5 * free, "{sunk}");
}
