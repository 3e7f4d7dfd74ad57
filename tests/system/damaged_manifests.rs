//! Damaged manifests: each is read or refused with its problems, soon and in little memory.

use crate::tremie::root;
use std::path::{Path, PathBuf};
use tremie::manifest;
use tremie_test_support::{DamagedInput, inputs};

/// Manifests of the examples and of the validation.
fn manifests() -> Vec<Vec<u8>> {
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in ["examples", "tests/validation"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let within = std::fs::read_dir(entry.unwrap().path()).into_iter().flatten().flatten();
            let is_manifest = |path: &PathBuf| {
                let name = path.file_name().unwrap_or_default();
                path.extension().is_some_and(|ending| ending == "toml")
                    && name != "case.toml"
                    && name != "Cargo.toml"
            };
            files.extend(within.map(|entry| entry.path()).filter(is_manifest));
        }
    }
    files.sort();
    assert!(files.len() > 30, "{files:?}");
    files.iter().map(|file| std::fs::read(file).unwrap()).collect()
}

/// All keys of manifests, and some values.
fn words() -> Vec<String> {
    let schema: serde_json::Value = serde_json::from_str(&manifest::schema_text()).unwrap();
    let mut words = Vec::new();
    collect(&schema, &mut words);
    words.sort();
    words.dedup();
    assert!(words.len() > 200, "{words:?}");
    let values = [
        "\"1 mm\"",
        "\"0 mm\"",
        "\"1e300 m\"",
        "\"-1 s\"",
        "[0, 0, 1]",
        "true",
        "{ ",
        " }",
        "[[",
        "]]",
        "\"",
        "\n[scene]\n",
        "\n[[scene.parts]]\n",
        "\n[[scene.bodies]]\n",
        "\n[components]\n",
        "1e400",
        "= ",
        "\"periodic\"",
        "\"1e-9 m\"",
        "fraction = 0.6\n",
        "\"1e9 m\"",
        "seed = 1\n",
        ".",
        "1979-05-27",
    ];
    words.extend(values.map(String::from));
    words
}

fn collect(schema: &serde_json::Value, words: &mut Vec<String>) {
    match schema {
        serde_json::Value::Object(map) => {
            if let Some(serde_json::Value::Object(properties)) = map.get("properties") {
                words.extend(properties.keys().cloned());
            }
            if let Some(serde_json::Value::Array(names)) = map.get("enum") {
                words.extend(names.iter().map(ToString::to_string));
            }
            map.values().for_each(|value| collect(value, words));
        }
        serde_json::Value::Array(all) => all.iter().for_each(|value| collect(value, words)),
        _ => {}
    }
}

fn try_manifests(count: u64) {
    let read = |bytes: &[u8]| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        match manifest::parse(Path::new("manifest.toml"), text, &[]) {
            Ok(manifest) => {
                let again = manifest::parse(Path::new("manifest.toml"), manifest.resolved(), &[]);
                let about = again.err().map(|errors| errors.to_string());
                assert_eq!(about, None, "a manifest as resolved is refused");
                "it is right".into()
            }
            Err(errors) => errors.problems.iter().map(|p| format!("{}; ", p.message)).collect(),
        }
    };
    let mut inputs_now = manifests();
    inputs_now.extend(inputs(&root().join("tests/system/inputs/manifests")));
    let words = words();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    // Tables, places of keys, and a scene with packings that are placed later.
    let memory = [4 << 20, 1000];
    DamagedInput { name: "manifests", inputs: inputs_now, words: &words, read: &read, memory }
        .try_many(count);
}

#[test]
fn damaged_manifests_are_read_or_refused() {
    try_manifests(1000);
}

#[test]
#[ignore = "minutes; CONTRIBUTING.md has the command"]
fn a_million_damaged_manifests_are_read_or_refused() {
    try_manifests(1_000_000);
}
