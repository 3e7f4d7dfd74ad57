//! Profiles of grains: files of a whole run, and their bits.

#[path = "../../components/profiles/tests/reader/mod.rs"]
pub mod reader;

use crate::tremie::{Ran, run_text, tremie};
use reader::read_npz;

/// Grains that fall through each other, dry, and settle on a floor.
pub const SHOWER: &str = r#"
[run]
until = "60 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["12 mm", "6 mm", "20 mm"]
x = "periodic"
y = "periodic"

[[scene.bodies]]
name = "grains"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "0 mm"], max = ["12 mm", "6 mm", "20 mm"], fraction = 0.3, diameter = ["0.9 mm", "1.1 mm"] }

[[scene.contacts]]
normal_stiffness = "500 N/m"
tangential_stiffness = "400 N/m"
friction = 0.4
restitution = 0.5

[[scene.profiles]]
name = "height"
along = ["z"]
bins = [10]
from = "10 ms"
every = "1 ms"
average = "20 ms"

[[scene.profiles]]
name = "section"
along = ["x", "z"]
bin_width = ["2.1 mm", "4 mm"]
max = ["12 mm", "6 mm", "16 mm"]
velocity = "displacement"
every = "2 ms"

[components]
grains = "grains-dem"

[outputs]
record = false
"#;

fn rows(ran: &Ran, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(ran.out.join(format!("profiles/{name}.csv"))).unwrap();
    let row = |line: &str| line.split(',').map(|text| text.parse().unwrap()).collect();
    text.lines().skip(1).map(row).collect()
}

fn bytes(options: &[&str]) -> Vec<Vec<u8>> {
    let ran = run_text(SHOWER, options).succeeded();
    let files = ["height.csv", "height.npz", "section.csv", "section.npz"];
    files.map(|file| std::fs::read(ran.out.join("profiles").join(file)).unwrap()).into()
}

#[test]
fn a_scene_with_profiles_leaves_tables_of_them() {
    let ran = run_text(SHOWER, &[]).succeeded();
    let summary = ran.summary().to_string();
    assert!(summary.contains("tables 3 of height, 1 of section"), "{summary}");
    let height = rows(&ran, "height");
    assert_eq!(height.len(), 3 * 10, "of 10 to 30, 30 to 50 and 50 to 60 ms");
    let (last, samples) = (&height[20..], height[29][2]);
    assert!((height[20][0] - 0.05).abs() < 1e-3 && (height[20][1] - 0.06).abs() < 1e-3);
    assert!((9.0..=11.0).contains(&samples), "{samples}");
    // All grains are in the box, in each table.
    let bodies = last.iter().map(|row| row[4]).sum::<f64>();
    for table in height.chunks(10) {
        let grains: f64 = table.iter().map(|row| row[4]).sum();
        assert!((grains / bodies - 1.0).abs() < 1e-9, "{grains} {bodies}");
        let fraction: f64 = table.iter().map(|row| 0.1 * row[5]).sum();
        assert!((0.29..0.31).contains(&fraction), "{fraction}");
    }
    // They have fallen: below they lie close and touch, above there is nothing.
    assert!(last[1][5] > 0.45 && last[9][5] < 0.05, "{} {}", last[1][5], last[9][5]);
    assert!(last[1][13] > 3.0, "contacts of a grain: {}", last[1][13]);
    assert!(last[1][16] > last[4][16], "the stress zz grows downwards");

    let section = rows(&ran, "section");
    assert_eq!(section.len(), 6 * 4, "12 mm in 2.1 mm are nearly 6 bins");
    let arrays = read_npz(&ran.out.join("profiles/section.npz"));
    assert_eq!(arrays["temperature"].shape, [1, 6, 4]);
    assert_eq!(arrays["z"].values.len(), 4);
    for (name, column) in [("solid_fraction", 6), ("velocity_z", 9), ("kinetic_stress_zz", 23)] {
        let of_rows = section.iter().map(|row| row[column].to_bits());
        assert!(of_rows.eq(arrays[name].values.iter().map(|value| value.to_bits())), "{name}");
    }

    let report = tremie().arg("report").arg(&ran.out).output().unwrap();
    let said = String::from_utf8_lossy(&report.stdout).into_owned();
    assert!(said.contains("5 panels of profiles"), "{said}");
    let picture = std::fs::read_to_string(ran.out.join("report.svg")).unwrap();
    for words in ["height: solid fraction", "height: velocity z", "section: solid fraction"] {
        assert!(picture.contains(words), "{words}");
    }
}

#[test]
fn tables_have_the_same_bits_however_the_run_is_carried_out() {
    let once = bytes(&[]);
    assert!(once == bytes(&["--in-process"]), "in one process");
    for threads in ["1", "2"] {
        let grains =
            format!("components.grains={{ program = \"grains-dem\", threads = {threads} }}");
        assert!(once == bytes(&["--set", &grains]), "on {threads} threads");
    }
    // Neither does it matter who looks besides.
    assert!(once == bytes(&["--set", "outputs.record=true", "--set", "outputs.frames=2 ms"]));
}

#[test]
fn profiles_change_no_bit_of_the_run() {
    let without: String = SHOWER.split("[[scene.profiles]]").next().unwrap().to_string()
        + &SHOWER[SHOWER.find("[components]").unwrap()..];
    let signals = |text: &str| run_text(text, &[]).succeeded().signals_text();
    assert!(signals(SHOWER) == signals(&without));
}

#[test]
fn a_run_that_ends_early_leaves_the_table_that_it_began() {
    let stop = "\n[[stop_when]]\nsignal = \"grains.mean_height\"\nbelow = 1.0\nafter = \"36 ms\"\n";
    let ran = run_text(&format!("{SHOWER}{stop}"), &[]).succeeded();
    let height = rows(&ran, "height");
    assert_eq!(height.len(), 2 * 10, "{}", ran.errors());
    let end = height[19][1];
    assert!(height[10][0] > 0.029 && end > 0.03 && end < 0.049, "{end}");
}

#[test]
fn the_plan_says_when_profiles_are_sampled() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    let check = |text: &str| {
        std::fs::write(&manifest, text).unwrap();
        let output = tremie().arg("check").arg(&manifest).output().unwrap();
        let read = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.success(), read(&output.stdout) + &read(&output.stderr))
    };
    let (right, text) = check(SHOWER);
    assert!(right && text.contains("profile height: 3 tables of 10 bins and 20 samples"), "{text}");
    let (_, text) = check(&SHOWER.replace("every = \"1 ms\"", "every = \"1 ns\""));
    assert!(text.contains("profile height: sampled each window"), "{text}");
    let clumped = SHOWER
        .replace("density = \"2500 kg/m3\"\n", "density = \"2500 kg/m3\"\nclump = \"lump\"\n");
    let (right, text) = check(&clumped);
    assert!(!right && text.contains("measures grains one by one"), "{text}");
}
