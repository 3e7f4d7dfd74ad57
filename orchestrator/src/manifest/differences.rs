//! Keys in which two manifests differ.

use super::path;
use serde_json::Value;
use std::path::Path;
use tremie_state::have_same_content;

/// Keys whose values differ between the tables of two manifests, defaults filled in. Of a table
/// that only one has, its own key. Files of the same content are no difference, wherever they are.
pub fn differences(one: &Value, other: &Value) -> Vec<String> {
    let mut found = Vec::new();
    compare("", one, other, &mut found);
    found
}

fn compare(at: &str, one: &Value, other: &Value, found: &mut Vec<String>) {
    match (one, other) {
        _ if one == other => {}
        (Value::String(one), Value::String(other)) if are_same_file(one, other) => {}
        (Value::Object(one), Value::Object(other)) => {
            let more = other.keys().filter(|key| !one.contains_key(*key));
            for key in one.keys().chain(more) {
                let null = &Value::Null;
                let (a, b) = (one.get(key).unwrap_or(null), other.get(key).unwrap_or(null));
                compare(&path::join(at, key), a, b, found);
            }
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            for (place, (a, b)) in one.iter().zip(other).enumerate() {
                compare(&path::item(at, place), a, b, found);
            }
        }
        _ => found.push(at.to_string()),
    }
}

/// True of the paths of two files that hold the same. Manifests have their files by absolute paths.
fn are_same_file(one: &str, other: &str) -> bool {
    let (one, other) = (Path::new(one), Path::new(other));
    let are_paths = one.is_absolute() && other.is_absolute();
    are_paths && have_same_content(one, other).is_ok_and(|same| same)
}
