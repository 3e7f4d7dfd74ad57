//! What to do about problems that say what is wrong, and no more.

use super::{path, resolve};
use serde_json::Value;
use tremie_messages::Problem;

/// Adds what to do to a problem without, where its words tell it.
pub(super) fn add_hint(problem: Problem) -> Problem {
    if problem.help.is_some() {
        return problem;
    }
    let help = missing(&problem)
        .or_else(|| quantity(&problem.message))
        .or_else(|| bare_value(&problem.message))
        .or_else(|| face(&problem));
    match help {
        Some(help) => problem.help(help),
        None => problem,
    }
}

/// What to do about an error in the text of a manifest, by the parser's words.
pub(super) fn syntax_hint(message: &str) -> Option<&'static str> {
    const HINTS: [(&str, &str); 6] = [
        ("duplicate key", "leave one of the two out"),
        ("array", "a comma, or the \"]\" that ends the list, is missing before this place"),
        ("inline table", "a comma, or the \"}\" that ends the table, is missing before this place"),
        ("must be quoted", "put the value into quotes, as \"20 ms\""),
        ("string", "the quote that ends the text is missing"),
        ("key", "a line is key = value, or a table in brackets: [scene.fluid]"),
    ];
    HINTS.iter().find(|(words, _)| message.contains(words)).map(|(_, hint)| *hint)
}

/// How a key that is missing would be written.
fn missing(problem: &Problem) -> Option<String> {
    let (_, key) = problem.message.strip_prefix("missing: ")?.split_once(" needs a key \"")?;
    let key = key.strip_suffix('"')?;
    let schema = resolve::schema();
    let mut at = &schema;
    for step in steps(&problem.key) {
        at = within(&schema, at, step)?;
    }
    match example(&schema, at) {
        Some(example) => Some(format!("add {key} = {example}")),
        None => Some(format!("add {key}: {}", at.get("description")?.as_str()?.lines().next()?)),
    }
}

/// The names on the way to a key; numbers of lists are left out.
fn steps(key: &str) -> impl Iterator<Item = &str> {
    key.split('.').map(|step| step.split('[').next().unwrap_or(step))
}

/// The schema of a key of a table, or of the tables in a list.
fn within<'a>(root: &'a Value, schema: &'a Value, key: &str) -> Option<&'a Value> {
    if let Some(found) = schema.get("properties").and_then(|keys| keys.get(key)) {
        return Some(found);
    }
    parts(root, schema).find_map(|part| within(root, part, key))
}

/// A value that a key may have, as TOML has it.
fn example(root: &Value, schema: &Value) -> Option<String> {
    if let Some(example) = schema.get("examples").and_then(|all| all.get(0)) {
        return Some(example.to_string());
    }
    if let Some(items) = schema.get("items") {
        let one = example(root, items)?;
        let count = schema.get("minItems").and_then(Value::as_u64).unwrap_or(1).clamp(1, 4);
        return Some(format!("[{}]", vec![one; count as usize].join(", ")));
    }
    parts(root, schema)
        .filter(|part| part.get("properties").is_none())
        .find_map(|part| example(root, part))
}

/// Schemas of which a schema is made.
fn parts<'a>(root: &'a Value, schema: &'a Value) -> impl Iterator<Item = &'a Value> {
    let named = schema.get("$ref").and_then(Value::as_str);
    let named = named.and_then(|name| root.get("$defs")?.get(name.strip_prefix("#/$defs/")?));
    let lists =
        ["anyOf", "oneOf", "allOf"].into_iter().filter_map(|kind| schema.get(kind)?.as_array());
    named.into_iter().chain(schema.get("items")).chain(lists.flatten())
}

/// What is wrong with a text that is no quantity.
fn quantity(message: &str) -> Option<String> {
    let (found, expected) = message.strip_prefix("found \"")?.split_once("\", expected ")?;
    let (kind, _) = expected.split_once(" with a unit")?;
    let begins = found.trim_start().starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    let digits = found.find(|c: char| !(c.is_ascii_digit() || "+-., ".contains(c)))?;
    let (number, unit) = (found[..digits].trim(), found[digits..].trim());
    if !begins {
        return None;
    }
    if number.contains(',') {
        return Some(format!("write a decimal point: \"{} {unit}\"", number.replace(',', ".")));
    }
    if kind == "a dynamic viscosity"
        && (unit.contains("m2/s") || unit.contains("m^2/s") || unit == "cSt")
    {
        return Some("that is a kinematic viscosity: multiply it by the density".into());
    }
    let is_power = unit.starts_with(['e', 'E']);
    if !found.contains(char::is_whitespace) && !is_power {
        return Some(format!("put a space between number and unit: \"{number} {unit}\""));
    }
    None
}

/// What is wrong with a text in place of a number, or of yes or no.
fn bare_value(message: &str) -> Option<String> {
    let (found, expected) = message.strip_prefix("found string \"")?.split_once("\", expected ")?;
    let is_number = expected.starts_with("a number") || expected.starts_with("a whole number");
    if is_number && found.parse::<f64>().is_ok() {
        return Some(format!("leave the quotes out: {found}"));
    }
    (expected == "a boolean").then(|| "write true or false, without quotes".into())
}

/// What else a face of the domain may be.
fn face(problem: &Problem) -> Option<String> {
    let parent = path::parent(&problem.key);
    let is_face =
        parent.starts_with("scene.domain.") && problem.message.contains("expected \"wall\"");
    is_face.then(|| {
        "a face through which fluid passes is a table, as { pressure = \"0 Pa\" } or { velocity = [\"0 m/s\", \"0 m/s\", \"1 m/s\"] }".into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hint(key: &str, message: &str) -> Option<String> {
        add_hint(Problem::new(key, message)).help
    }

    #[test]
    fn a_key_that_is_missing_comes_with_a_value() {
        let missing = |key: &str| {
            let (table, own) = key.rsplit_once('.').unwrap();
            hint(key, &format!("missing: {table} needs a key \"{own}\"")).unwrap()
        };
        assert_eq!(missing("scene.fluid.density"), "add density = \"970 kg/m3\"");
        assert_eq!(missing("run.until"), "add until = \"20 ms\"");
        assert_eq!(missing("scene.domain.size"), "add size = [\"0.3 mm\", \"0.3 mm\", \"0.3 mm\"]");
        assert_eq!(missing("settings.fluid-lbm.cell"), "add cell = \"0.3 mm\"");
        assert!(missing("scene.bodies[3].name").starts_with("add name"));
    }

    #[test]
    fn quantities_that_are_none_come_with_what_is_wrong() {
        let found = |text: &str, kind: &str| {
            hint("x", &format!("found \"{text}\", expected {kind} with a unit, as \"1 x\""))
        };
        let length = |text: &str| found(text, "a length");
        assert_eq!(length("12mm").unwrap(), "put a space between number and unit: \"12 mm\"");
        assert_eq!(length("0,5 mm").unwrap(), "write a decimal point: \"0.5 mm\"");
        assert_eq!(length("1e3"), None);
        assert_eq!(length("mm"), None);
        assert_eq!(length("ü"), None);
        assert!(found("1e-6 m2/s", "a dynamic viscosity").unwrap().contains("density"));
    }

    #[test]
    fn a_text_in_place_of_a_number_comes_without_quotes() {
        assert_eq!(
            hint("x", "found string \"0.3\", expected a number").unwrap(),
            "leave the quotes out: 0.3"
        );
        assert_eq!(hint("x", "found string \"some\", expected a number"), None);
    }
}
