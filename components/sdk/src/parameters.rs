//! Reading a component's own parameters, with errors that point at the key.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use tremie_messages::Problem;

/// Reads `parameters` as `P`, which should carry `deny_unknown_fields`.
///
/// # Errors
/// One problem: the key (relative to the component's table), what was found and expected.
pub fn read<P: DeserializeOwned>(parameters: &Map<String, Value>) -> Result<P, Vec<Problem>> {
    serde_path_to_error::deserialize(Value::Object(parameters.clone())).map_err(|error| {
        let path = match error.path().to_string() {
            path if path == "." => String::new(),
            path => path,
        };
        vec![explain(&path, &error.into_inner().to_string())]
    })
}

/// Turns serde's sentence on an unknown field into one that names the nearest valid key.
pub fn explain(path: &str, message: &str) -> Problem {
    match message.strip_prefix("unknown field `").and_then(|rest| rest.split_once('`')) {
        Some((unknown, rest)) => {
            // serde_path_to_error ends the path with the unknown field itself.
            let key = if path.rsplit('.').next() == Some(unknown) {
                path.to_string()
            } else {
                [path, unknown]
                    .iter()
                    .filter(|part| !part.is_empty())
                    .copied()
                    .collect::<Vec<_>>()
                    .join(".")
            };
            let valid: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
            let problem = Problem::of_parameter(&key, format!("unknown key \"{unknown}\""));
            match nearest(unknown, &valid) {
                Some(near) => problem.help(format!("did you mean \"{near}\"?")),
                None => problem.help(format!("valid keys: {}", valid.join(", "))),
            }
        }
        None => Problem::of_parameter(path, message),
    }
}

/// The candidate closest to `word`, if one is close enough to have been meant.
pub fn nearest<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    candidates
        .iter()
        .map(|candidate| (strsim::damerau_levenshtein(word, candidate), *candidate))
        .filter(|(distance, candidate)| *distance <= 1 + candidate.len() / 3)
        .min()
        .map(|(_, candidate)| candidate)
}
