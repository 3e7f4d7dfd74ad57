//! Numbers of a run before it begins, with verdicts and remedies.

use crate::tremie::{SMALL, run_text, tremie};
use serde_json::Value;

/// Numbers of a published model of a valve in a slurry, with its grains in a plain box.
const PUBLISHED: &str = r#"
[run]
until = "1 ms"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["12 mm", "12 mm", "12 mm"]

[scene.fluid]
density = "1000 kg/m3"
viscosity = "1 mPa s"
expected_speed = "6 m/s"

[[scene.bodies]]
name = "grains"
density = "2500 kg/m3"
packing = { min = ["0 mm", "0 mm", "0 mm"], max = ["12 mm", "12 mm", "12 mm"], fraction = 0.05, diameter = "0.8 mm" }

[[scene.contacts]]
normal_stiffness = "1e7 N/m"
tangential_stiffness = "0.8e7 N/m"
friction = 0.4
normal_damping = "3 kg/s"
tangential_damping = "0 kg/s"
tension = true

[components]
fluid = "fluid-lbm"
grains = "grains-dem"

[settings.fluid-lbm]
cell = "0.3 mm"
time_step = "0.12 us"
smagorinsky = 0.4

[settings.grains-dem]
time_step = "0.05 us"

[outputs]
record = false
"#;

/// Exit code of `tremie check --json` on a manifest, and the event of the plan.
fn check(text: &str, options: &[&str]) -> (Option<i32>, Value) {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, text).unwrap();
    let output = tremie().args(["check", "--json"]).arg(&manifest).args(options).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let events: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let plan = events.iter().find(|event| event["event"] == "plan");
    let plan = plan
        .unwrap_or_else(|| panic!("no plan: {said}{}", String::from_utf8_lossy(&output.stderr)));
    (output.status.code(), plan.clone())
}

/// The finding of a component about a quantity.
#[track_caller]
fn finding<'a>(plan: &'a Value, component: &str, quantity: &str) -> &'a Value {
    let findings = plan["findings"].as_array().unwrap();
    let of = |f: &&Value| f["component"] == component && f["quantity"] == quantity;
    findings.iter().find(of).unwrap_or_else(|| panic!("no {quantity} of {component}: {plan:#}"))
}

/// The finding about the lightest pair that is damped most: that of two grains.
#[track_caller]
fn strongest_damping(plan: &Value) -> &Value {
    let findings = plan["findings"].as_array().unwrap().iter();
    let pairs = findings.filter(|f| f["quantity"].as_str().unwrap().starts_with("damping ratio"));
    let ratio = |f: &&Value| f["value"].as_f64().unwrap();
    pairs.max_by(|a, b| ratio(a).total_cmp(&ratio(b))).expect("no damping ratio")
}

/// Expects a value to three digits, and a verdict that is not ok with a reason and a remedy.
#[track_caller]
fn is_pointed_out(finding: &Value, value: f64) {
    let found = finding["value"].as_f64().unwrap();
    assert!((found / value - 1.0).abs() < 2e-3, "{finding:#}");
    assert_ne!(finding["verdict"], "ok", "{finding:#}");
    for key in ["why", "remedy"] {
        let sentence = finding[key].as_str().unwrap();
        assert!(sentence.contains(|c: char| c.is_ascii_digit()) || key == "remedy", "{finding:#}");
        assert!(sentence.len() > 20, "{finding:#}");
    }
}

#[test]
fn the_published_numbers_are_doubted_one_by_one() {
    let (code, plan) = check(PUBLISHED, &[]);
    assert_eq!(code, Some(0), "doubtful, but not wrong");
    is_pointed_out(finding(&plan, "fluid", "cells across the smallest sphere"), 2.667);
    let tau = finding(&plan, "fluid", "relaxation time");
    is_pointed_out(tau, 0.5);
    assert!((tau["value"].as_f64().unwrap() - 0.500_004).abs() < 1e-9, "{tau:#}");
    let ratio = finding(&plan, "run", "step ratio of grains");
    is_pointed_out(ratio, 2.4);
    assert!(ratio["why"].as_str().unwrap().contains("3 steps of 4e-8 s"), "{ratio:#}");
    assert!(ratio["remedy"].as_str().unwrap().contains("1e-7 s"), "{ratio:#}");
    is_pointed_out(strongest_damping(&plan), 0.819);
    is_pointed_out(finding(&plan, "grains", "steps in the shortest collision"), 11.5);
    for quantity in ["memory", "shared memory", "disk, at most"] {
        assert_eq!(finding(&plan, "run", quantity)["verdict"], "ok", "{plan:#}");
    }
}

#[test]
fn the_smallest_grain_counts() {
    let spheres = "spheres = [{ position = [\"3 mm\", \"3 mm\", \"3 mm\"], diameter = \"0.727 mm\" }, { position = [\"6 mm\", \"3 mm\", \"3 mm\"], diameter = \"0.727 mm\" }, { position = [\"9 mm\", \"3 mm\", \"3 mm\"], diameter = \"0.8 mm\" }]";
    let start = PUBLISHED.find("packing").unwrap();
    let end = PUBLISHED[start..].find('\n').unwrap() + start;
    let (_, plan) = check(&format!("{}{spheres}{}", &PUBLISHED[..start], &PUBLISHED[end..]), &[]);
    is_pointed_out(finding(&plan, "fluid", "cells across the smallest sphere"), 2.423);
    is_pointed_out(strongest_damping(&plan), 0.946);
}

#[test]
fn steps_that_fit_are_ok() {
    let (_, plan) = check(PUBLISHED, &["--set", "settings.grains-dem.time_step=0.04 us"]);
    let ratio = finding(&plan, "run", "step ratio of grains");
    assert!((ratio["value"].as_f64().unwrap() - 3.0).abs() < 1e-9, "{ratio:#}");
    assert_eq!(ratio["verdict"], "ok");
}

#[test]
fn a_person_reads_a_table_and_the_remedies() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, PUBLISHED).unwrap();
    let output = tremie().arg("check").arg(&manifest).output().unwrap();
    assert_eq!(
        String::from_utf8_lossy(&output.stderr),
        "",
        "what was asked for is on standard output"
    );
    let said = String::from_utf8_lossy(&output.stdout);
    for words in
        ["verdict", "0.500004", "doubtful: grains: damping ratio", "remedy: ", "findings: "]
    {
        assert!(said.contains(words), "expected \"{words}\" in:\n{said}");
    }
}

#[test]
fn a_run_keeps_its_findings_and_says_them() {
    let ran = run_text(SMALL, &["--until", "2 ms"]).succeeded();
    let summary = ran.summary();
    let findings = summary["findings"].as_array().unwrap();
    let cells = findings.iter().find(|f| f["quantity"] == "cells across the smallest sphere");
    assert_eq!(cells.unwrap()["value"], 6.0);
    assert!(ran.errors().contains("doubtful: fluid: cells across"), "{}", ran.errors());
}

#[test]
fn a_lattice_too_soft_for_the_bed_is_wrong() {
    let bed = "packing = { min = [\"0 mm\", \"0 mm\", \"0 mm\"], max = [\"12 mm\", \"12 mm\", \"16 mm\"], fraction = 0.3, diameter = \"4 mm\" }";
    let start = SMALL.find("spheres").unwrap();
    let end = SMALL.find("[[scene.contacts]]").unwrap();
    let text = format!("{}{bed}\n\n{}", &SMALL[..start], &SMALL[end..]);
    let quantity = "weight of the grains over lattice stiffness";
    let (code, plan) = check(&text, &["--set", "settings.fluid-lbm.time_step=0.5 ms"]);
    let soft = finding(&plan, "fluid", quantity);
    // 0.3 (2500 - 1000) 9.81 0.016 Pa over 1000 (0.5e-3/0.5e-3)^2 / 3 Pa.
    is_pointed_out(soft, 0.3 * 1500.0 * 9.81 * 0.016 / (1000.0 / 3.0));
    assert_eq!((code, soft["verdict"].as_str()), (Some(1), Some("wrong")));
    let (_, plan) = check(&text, &["--set", "settings.fluid-lbm.time_step=0.05 ms"]);
    assert_eq!(finding(&plan, "fluid", quantity)["verdict"], "ok");
}

#[test]
fn a_wrong_number_is_called_wrong_once() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, PUBLISHED).unwrap();
    let output = tremie()
        .arg("check")
        .arg(&manifest)
        .args(["--quiet", "--set", "settings.fluid-lbm.cell=0.6 mm"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("wrong: fluid: cells across the smallest sphere is 1.33333"), "{said}");
    assert!(!said.contains("warning: wrong"), "{said}");
    assert_eq!(output.status.code(), Some(1));
}

/// A wire, a ball and a sheet of 0.4 mm in cells of 0.5 mm; the sheet on the floor is the floor.
#[test]
fn parts_thinner_than_a_cell_are_told() {
    let said = |shape: &str, height: &str| {
        let text = format!(
            r#"
[run]
until = "10 ms"
[scene.domain]
size = ["16 mm", "16 mm", "16 mm"]
x = "periodic"
y = "periodic"
[scene.fluid]
density = "1000 kg/m3"
viscosity = "0.05 Pa s"
expected_speed = "0.05 m/s"
[[scene.parts]]
name = "own"
{shape}
position = ["8.1 mm", "8 mm", "{height}"]
[components]
fluid = "fluid-lbm"
[settings.fluid-lbm]
cell = "0.5 mm"
"#
        );
        check(&text, &[])
    };
    let wire = "box = { size = [\"0.4 mm\", \"20 mm\", \"0.4 mm\"] }";
    for shape in [wire, "sphere = { radius = \"0.2 mm\" }"] {
        let (code, plan) = said(shape, "8 mm");
        assert_eq!(code, Some(1), "{plan:#}");
        is_pointed_out(finding(&plan, "fluid", "cells across own"), 0.8);
    }
    let sheet = "box = { size = [\"20 mm\", \"20 mm\", \"0.4 mm\"] }";
    let (code, plan) = said(sheet, "8 mm");
    assert_eq!(code, Some(0), "{plan:#}");
    is_pointed_out(finding(&plan, "fluid", "cells through own"), 0.8);
    let (_, plan) = said(sheet, "0.2 mm");
    let findings = plan["findings"].as_array().unwrap();
    let about = |f: &&Value| f["quantity"].as_str().unwrap().ends_with(" own");
    assert_eq!(findings.iter().find(about), None);
}

#[test]
fn a_low_relaxation_time_with_few_cells_a_grain_is_doubted() {
    // At 0.51 the lattice itself is well damped; three cells a grain do not see the layer around
    // it.
    let sets = [
        "settings.fluid-lbm.cell=1 mm",
        "settings.fluid-lbm.time_step=66.66666667 us",
        "scene.fluid.expected_speed=0.8 m/s",
    ];
    let (_, plan) = check(SMALL, &sets.map(|set| ["--set", set]).concat());
    let found = finding(&plan, "fluid", "relaxation time");
    assert!((found["value"].as_f64().unwrap() - 0.51).abs() < 1e-6, "{found:#}");
    assert_eq!(found["verdict"], "ok");
    // D = 3 cells, Re = 0.8 3e-3 / 5e-5.
    is_pointed_out(
        finding(&plan, "fluid", "cells in the boundary layer of the smallest sphere"),
        3.0 / 48_f64.sqrt(),
    );
}

#[test]
fn a_measured_run_tells_how_long_it_takes() {
    let (code, plan) = check(SMALL, &["--measure"]);
    let time = finding(&plan, "run", "wall time");
    assert!(time["value"].as_f64().unwrap() > 0.0, "{time:#}");
    assert!(time["why"].as_str().unwrap().contains("windows at"), "{time:#}");
    assert_eq!(code, Some(0));
}

/// Grains alone in a box, to be changed by replacing words.
const DRY: &str = r#"
[run]
until = "0.02 s"

[scene]
gravity = ["0 m/s2", "0 m/s2", "-9.81 m/s2"]

[scene.domain]
size = ["20 mm", "20 mm", "20 mm"]

[[scene.bodies]]
name = "g"
density = "2500 kg/m3"
spheres = [
    { position = ["10 mm", "10 mm", "10 mm"], diameter = "4 mm" },
    { position = ["5 mm", "5 mm", "5 mm"], diameter = "2 mm", velocity = ["0 m/s", "0 m/s", "-0.1 m/s"] },
]

[[scene.contacts]]
normal_stiffness = "5000 N/m"
tangential_stiffness = "4000 N/m"
friction = 0.3
restitution = 0.5

[components]
grains = "grains-dem"

[outputs]
record = false
"#;

/// A run too long to end is pointed out, with the grain, pair or key that makes its steps short.
#[test]
fn runs_of_absurd_length_say_what_makes_them_long() {
    let quantity = "steps of the run";
    let (_, plan) = check(DRY, &[]);
    assert_eq!(finding(&plan, "run", quantity)["verdict"], "ok");
    let tiny = DRY.replace("\"2 mm\"", "\"1e-6 mm\"");
    let stiff = DRY.replace("5000 N/m", "5e17 N/m").replace("4000 N/m", "4e17 N/m");
    let light = DRY.replace("2500 kg/m3", "1e-13 kg/m3");
    let few = |text: &str| text.replace("0.02 s", "20 s");
    for (text, options, verdict, words) in [
        (
            tiny.clone(),
            &[][..],
            "wrong",
            "smallest grain 1e-9 m (of body 1 of scene.bodies[0] \"g\")",
        ),
        (stiff, &[], "wrong", "normal_stiffness 5e17 N/m"),
        (light, &[], "wrong", "g with g"),
        (DRY.into(), &["--set", "run.until=1e10 s"], "wrong", "1e10 s (run.until)"),
        (DRY.into(), &["--set", "run.until=10000 s"], "doubtful", "10000 s (run.until)"),
        (
            few(DRY),
            &["--set", "settings.grains-dem.time_step=1e-8 s"],
            "doubtful",
            "time_step in its settings",
        ),
        (SMALL.into(), &["--set", "run.until=1e8 s"], "wrong", "viscosity of"),
        (
            SMALL.into(),
            &[
                "--set",
                "run.until=100 s",
                "--set",
                "settings.fluid-lbm.time_step=1e-7 s",
                "--set",
                "settings.fluid-lbm.smagorinsky=0.1",
            ],
            "doubtful",
            "fluid steps",
        ),
    ] {
        let (code, plan) = check(&text, options);
        let found = finding(&plan, "run", quantity);
        assert_eq!(found["verdict"], verdict, "{options:?} {found:#}");
        assert_eq!(code, Some(i32::from(verdict == "wrong")), "{options:?}");
        let why = found["why"].as_str().unwrap();
        assert!(why.contains(words) && why.contains("about "), "{options:?} {why}");
        assert!(found["remedy"].as_str().unwrap().contains("run.until"), "{found:#}");
    }
    // More than can be counted is refused, with the same words.
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, tiny).unwrap();
    let output = tremie().arg("check").arg(&manifest).args(["--until", "1 h"]).output();
    let output = output.unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(2) {
        assert!(said.contains("smallest grain 1e-9 m"), "{said}");
    }
}

/// Contacts that are too soft are doubted before the run, by what it gives and lets fall, and after
/// it, by what was.
#[test]
fn soft_contacts_are_doubted_before_and_after_a_run() {
    let plate = r#"
[[scene.parts]]
name = "plate"
box = { size = ["20 mm", "20 mm", "1 mm"] }
position = ["10 mm", "10 mm", "4 mm"]

[[scene.contacts]]"#;
    let fast = |text: &str| {
        text.replace("-0.1 m/s", "-2 m/s").replace("\"5 mm\"], diameter", "\"8 mm\"], diameter")
    };
    let soft = |text: &str| text.replace("5000 N/m", "200 N/m").replace("4000 N/m", "160 N/m");
    let onto = |text: &str| text.replace("\n[[scene.contacts]]", plate);
    let two = |text: &str| {
        // Half of the speed each, against each other.
        text.replace("\"8 mm\"], diameter = \"2 mm\", velocity = [\"0 m/s\", \"0 m/s\", \"-2 m/s\"]", "\"2 mm\"], diameter = \"2 mm\", velocity = [\"1.2 m/s\", \"0 m/s\", \"0 m/s\"]")
            .replace("[\"10 mm\", \"10 mm\", \"10 mm\"], diameter = \"4 mm\"", "[\"15 mm\", \"5 mm\", \"2 mm\"], diameter = \"2 mm\", velocity = [\"-1.2 m/s\", \"0 m/s\", \"0 m/s\"]")
    };
    let joined = |text: &str| {
        text.replace("density = \"2500 kg/m3\"\n", "density = \"2500 kg/m3\"\nclump = \"c\"\n")
            .replace(
                "diameter = \"4 mm\" }",
                "diameter = \"4 mm\", velocity = [\"0 m/s\", \"0 m/s\", \"-2 m/s\"] }",
            )
    };
    let hertz = |text: &str| {
        text.replace("normal_stiffness = \"5000 N/m\"\ntangential_stiffness = \"4000 N/m\"", "hertz = true")
            .replace("[[scene.bodies]]", "[scene.materials.g]\ndensity = \"2500 kg/m3\"\nyoungs_modulus = \"1000 kPa\"\npoisson_ratio = 0.3\n\n[scene.materials.wall]\ndensity = \"2500 kg/m3\"\nyoungs_modulus = \"1000 kPa\"\npoisson_ratio = 0.3\n\n[[scene.bodies]]")
    };
    let (before, after) =
        ("overlap at an impact over the radius", "greatest overlap over the smaller radius");
    for (name, text, doubted) in [
        ("stiff and slow", DRY.to_string(), false),
        ("onto a wall", soft(&fast(DRY)), true),
        ("onto a part", onto(&soft(&fast(DRY))), true),
        ("against each other", two(&soft(&fast(DRY))), true),
        ("a clump", joined(&soft(&fast(DRY))), true),
        ("hertz", hertz(&fast(DRY)), true),
    ] {
        let ran = run_text(&text, &[]);
        let summary = ran.succeeded().summary();
        let findings = summary["findings"].as_array().unwrap();
        let of = |quantity: &str| {
            let found = findings.iter().find(|f| f["quantity"] == quantity);
            found.unwrap_or_else(|| panic!("{name}: no {quantity}")).clone()
        };
        let (expected, was) = (of(before), of(after));
        let ratio = |f: &Value| f["value"].as_f64().unwrap();
        println!("{name}: expected {}, was {}", ratio(&expected), ratio(&was));
        let verdict = if doubted { "doubtful" } else { "ok" };
        assert_eq!(
            (&expected["verdict"], &was["verdict"]),
            (&verdict.into(), &verdict.into()),
            "{name}"
        );
        assert_eq!(was["value"], summary["signals"]["grains.max_overlap_ratio"]["max"], "{name}");
        assert!(!doubted || expected["remedy"].as_str().unwrap().len() > 20, "{name}");
    }
    let said = run_text(&soft(&fast(DRY)), &["--quiet"]).succeeded().errors();
    assert!(said.contains("doubtful: grains: greatest overlap"), "{said}");
}
