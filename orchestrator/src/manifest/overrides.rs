//! `--set key=value`: values of the command line, laid over the manifest.

use super::path::{self, Step};
use super::source::{KeyPlace, Source};
use serde_json::{Map, Value};
use tremie_messages::Problem;

/// Lays `sets` over `tree` in order; each problem is placed at its `--set`.
pub(super) fn apply(
    tree: &mut Value,
    sets: &[(String, String)],
    source: &mut Source,
    problems: &mut Vec<Problem>,
) {
    for (key, text) in sets {
        let place = KeyPlace::CommandLine(format!("--set {key}={text}"));
        let outcome = parse_key(key).and_then(|steps| {
            let slot = descend(tree, &steps)?;
            *slot = parse_value(text)?;
            Ok(())
        });
        match outcome {
            Ok(()) => {
                source.forget(key);
                place_parents(key, &place, source);
            }
            Err(message) => problems.push(Problem::new(key, message)),
        }
        source.put(key.clone(), place);
    }
}

fn parse_key(key: &str) -> Result<Vec<Step>, String> {
    path::parse(key)
        .ok_or_else(|| format!("\"{key}\" is not a key, as scene.bodies[0].density is one"))
}

/// A value in TOML, or the text itself.
fn parse_value(text: &str) -> Result<Value, String> {
    let mut source = Source::new("".as_ref(), format!("value = {text}"));
    let mut problems = Vec::new();
    let tree = super::tree::read(&mut source, &mut problems);
    if problems.iter().any(|problem| !path::is_within(&problem.key, "value")) {
        return Ok(Value::String(text.trim().to_string()));
    }
    match (problems.pop(), tree) {
        (Some(problem), _) => Err(problem.message),
        (None, Value::Object(mut map)) if map.len() == 1 => {
            Ok(map.remove("value").unwrap_or_default())
        }
        _ => Ok(Value::String(text.trim().to_string())),
    }
}

/// The slot that the steps lead to; tables on the way are made where there are none.
fn descend<'a>(tree: &'a mut Value, steps: &[Step]) -> Result<&'a mut Value, String> {
    let mut slot = tree;
    let mut at = String::new();
    for (place, step) in steps.iter().enumerate() {
        slot = match step {
            Step::Key(key) => {
                widen(slot, &at);
                if let Value::Array(entries) = slot {
                    return Err(by_number(entries, &at, key, &steps[place + 1..]));
                }
                let table = slot.as_object_mut().ok_or_else(|| {
                    format!("{at} is a value, and has nothing below it: write {at}=VALUE")
                })?;
                at = path::join(&at, key);
                table.entry(key.clone()).or_insert(Value::Null)
            }
            Step::Index(index) => {
                let keys = slot.as_object().map(|table| table.keys().cloned().collect::<Vec<_>>());
                let entries = slot.as_array_mut().ok_or_else(|| match keys {
                    Some(keys) => format!("{at} is not a list; its keys are {}", keys.join(", ")),
                    None => format!("{at} is not a list"),
                })?;
                let count = entries.len();
                let entry = entries.get_mut(*index);
                let slot =
                    entry.ok_or_else(|| format!("{at} has {count} entries, counted from 0"))?;
                at = path::item(&at, *index);
                slot
            }
        };
    }
    Ok(slot)
}

/// Message that tells the key of an entry of a list, which was named as keys of tables are: by
/// number or by name.
fn by_number(entries: &[Value], at: &str, key: &str, rest: &[Step]) -> String {
    let named = |entry: &Value| entry.get("name").and_then(Value::as_str) == Some(key);
    let count = entries.len();
    let index = match key.trim().parse::<usize>() {
        Ok(index) if index < count => Some(index),
        Ok(_) => {
            return format!(
                "{at} is a list of {count} entries, counted from 0: {at}[{key}] is not there"
            );
        }
        Err(_) => entries.iter().position(named),
    };
    let below = rest.iter().fold(String::new(), |below, step| match step {
        // A number there is meant alike.
        Step::Key(key) if key.parse::<usize>().is_ok() => format!("{below}[{key}]"),
        Step::Key(key) => format!("{below}.{key}"),
        Step::Index(index) => format!("{below}[{index}]"),
    });
    if let Some(index) = index {
        return format!("{at} is a list: write {at}[{index}]{below}");
    }
    let names: Vec<_> = entries.iter().filter_map(|entry| entry.get("name")?.as_str()).collect();
    match names[..] {
        [] => format!("{at} is a list of {count} entries, which are told by number: {at}[0]"),
        _ => format!("{at} is a list of {}: write {at}[0]{below} for the first", names.join(", ")),
    }
}

/// Makes a table of nothing, and of a component that is given by its program alone.
fn widen(slot: &mut Value, at: &str) {
    match slot {
        Value::Null => *slot = Value::Object(Map::new()),
        Value::String(program) if path::parent(at) == "components" => {
            let program = Value::String(std::mem::take(program));
            *slot = Value::Object(Map::from_iter([("program".to_string(), program)]));
        }
        _ => {}
    }
}

/// A table that only the command line made has its place there.
fn place_parents(key: &str, place: &KeyPlace, source: &mut Source) {
    let mut at = path::parent(key);
    while !at.is_empty() {
        if !source.knows(at) {
            source.put(at.to_string(), place.clone());
        }
        at = path::parent(at);
    }
}
