//! Wrong input: one clear error that points at the line, before anything starts.

use crate::tremie::{SMALL, description, run_text, script, tremie};

/// Changes one place of the small manifest and expects an error that holds all of `expected`.
#[track_caller]
fn refused(from: &str, to: &str, expected: &[&str]) {
    assert!(SMALL.contains(from), "the manifest has no {from}");
    let ran = run_text(&SMALL.replacen(from, to, 1), &[]);
    let errors = ran.errors();
    assert_eq!(ran.code(), Some(2), "{errors}");
    for word in expected {
        assert!(errors.contains(word), "expected \"{word}\" in:\n{errors}");
    }
    assert_eq!(errors.matches("error").count(), 1, "expected one error:\n{errors}");
    assert!(!ran.out.exists(), "a refused run left a folder behind");
}

#[test]
fn an_unknown_key_comes_with_the_nearest_valid_one() {
    refused("viscosity =", "viscocity =", &["manifest.toml:13", "viscocity", "viscosity"]);
}

#[test]
fn an_unknown_key_of_a_component_does_so_too() {
    refused("cell =", "cel =", &["manifest.toml:35", "cel", "\"cell\""]);
}

#[test]
fn a_wrong_unit_names_what_was_expected() {
    refused("\"0.05 Pa s\"", "\"0.05 kg\"", &["manifest.toml:13", "0.05 kg", "viscosity", "Pa s"]);
}

#[test]
fn a_bare_number_is_no_quantity() {
    refused("\"0.05 Pa s\"", "0.05", &["manifest.toml:13", "0.05"]);
}

#[test]
fn a_negative_viscosity_is_refused() {
    refused("\"0.05 Pa s\"", "\"-0.05 Pa s\"", &["manifest.toml:13", "viscosity", "-0.05"]);
}

#[test]
fn a_relaxation_time_too_close_to_one_half_is_refused() {
    refused(
        "cell = \"0.5 mm\"",
        "cell = \"0.5 mm\"\nrelaxation_time = 0.5001",
        &["relaxation", "0.5001"],
    );
}

#[test]
fn contacts_in_the_form_of_old_manifests_come_with_the_new_form() {
    refused(
        "[[scene.contacts]]\nnormal_stiffness = \"50 N/m\"\ntangential_stiffness = \"40 N/m\"\nfriction = 0.3\nrestitution = 0.5",
        "[scene.contacts]\nbody_body = { normal_stiffness = \"50 N/m\", tangential_stiffness = \"40 N/m\", friction = 0.3, restitution = 0.5 }",
        &["scene.contacts", "[[scene.contacts]]", "body_wall"],
    );
}

#[test]
fn a_mach_number_over_the_limit_is_refused_with_a_remedy() {
    let to = "viscosity = \"0.05 Pa s\"\nexpected_speed = \"3 m/s\"";
    let text = SMALL.replacen("viscosity = \"0.05 Pa s\"", to, 1).replacen(
        "cell = \"0.5 mm\"",
        "cell = \"0.5 mm\"\ntime_step = \"0.2 ms\"",
        1,
    );
    let ran = run_text(&text, &[]);
    assert_eq!(ran.code(), Some(2), "{}", ran.errors());
    assert!(ran.errors().contains("Mach"), "{}", ran.errors());
}

#[test]
fn overlapping_grains_are_named() {
    refused("\"8 mm\", \"8 mm\", \"8 mm\"", "\"5 mm\", \"4 mm\", \"4 mm\"", &["overlap"]);
}

#[test]
fn a_packing_that_cannot_be_made_is_refused_at_its_line() {
    let start = SMALL.find("spheres").unwrap();
    let end = SMALL.find("[[scene.contacts]]").unwrap();
    let packing = "packing = { min = [\"0 mm\", \"0 mm\", \"0 mm\"], max = [\"12 mm\", \"12 mm\", \"16 mm\"], fraction = 0.7, diameter = \"3 mm\" }\n\n";
    refused(
        &SMALL[start..end],
        packing,
        &["scene.bodies[0].packing.fraction", "manifest.toml:18", "is 0.7000, but only 0."],
    );
}

#[test]
fn a_missing_program_comes_with_where_it_was_looked_for() {
    refused("\"fluid-lbm\"\n", "\"fluid-lbn\"\n", &["fluid-lbn", "fluid-lbm"]);
}

#[test]
fn a_fixed_ratio_that_cannot_be_is_refused_with_what_would_do() {
    refused("\"grains-dem\"", "{ program = \"grains-dem\", sync_iter = 1 }", &["sync_iter"]);
}

#[test]
fn a_component_of_another_interface_version_is_refused() {
    let home = tempfile::tempdir().unwrap();
    let lines = format!("read line\necho '{}'\nread line", description(999));
    let program = script(home.path(), "old-fluid", &lines);
    let named = format!("fluid = {program:?}");
    refused("fluid = \"fluid-lbm\"", &named, &["999", "interface version"]);
}

#[test]
fn check_finds_the_same_and_runs_nothing() {
    let home = tempfile::tempdir().unwrap();
    let manifest = home.path().join("manifest.toml");
    std::fs::write(&manifest, SMALL.replacen("viscosity =", "viscocity =", 1)).unwrap();
    let output = tremie().arg("check").arg(&manifest).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    std::fs::write(&manifest, SMALL).unwrap();
    let output = tremie().arg("check").arg(&manifest).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}");
    for word in ["fluid-lbm", "grains-dem", "substeps", "tau"] {
        assert!(said.contains(word), "expected \"{word}\" in the plan:\n{said}");
    }
}

/// Runs `tremie COMMAND --json` and expects that all it says is one event of this kind.
#[track_caller]
fn says_one_event(arguments: &[&str], code: i32, kind: &str) -> serde_json::Value {
    let output = tremie().args(arguments).arg("--json").output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    assert_eq!(output.status.code(), Some(code));
    let said = String::from_utf8_lossy(&output.stdout);
    let events: Vec<serde_json::Value> =
        said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(events.len(), 1, "{said}");
    assert_eq!(events[0]["event"], kind, "{said}");
    events[0].clone()
}

#[test]
fn errors_are_events_where_a_program_listens() {
    let home = tempfile::tempdir().unwrap();
    let (manifest, out) = (home.path().join("manifest.toml"), home.path().join("out"));
    let [manifest, out] = [&manifest, &out].map(|path| path.to_str().unwrap());
    for arguments in [&["check", manifest][..], &["run", manifest, "--out", out]] {
        std::fs::write(manifest, SMALL.replacen("viscosity =", "viscocity =", 1)).unwrap();
        assert_eq!(says_one_event(arguments, 2, "problem")["line"], 13);
        std::fs::write(manifest, SMALL.replacen("cell =", "cel =", 1)).unwrap();
        assert_eq!(says_one_event(arguments, 2, "problem")["line"], 35);
    }
    std::fs::write(manifest, SMALL).unwrap();
    std::fs::create_dir(out).unwrap();
    std::fs::write(home.path().join("out/taken"), "").unwrap();
    let event = says_one_event(&["run", manifest, "--out", out], 1, "error");
    assert!(event["text"].as_str().unwrap().contains("holds something already"), "{event}");
}
