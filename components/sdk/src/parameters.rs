//! Reading a component's own parameters, with errors that point at the key.

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use tremie_messages::Problem;

pub use tremie_messages::nearest;

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

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use serde_json::json;

    #[derive(Debug, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Settings {
        cell: f64,
        #[serde(default)]
        inner: Inner,
    }

    #[derive(Debug, Default, PartialEq, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Inner {
        #[serde(default)]
        threads: u32,
    }

    fn problem(value: Value) -> Problem {
        read::<Settings>(value.as_object().unwrap()).unwrap_err().remove(0)
    }

    #[test]
    fn an_unknown_key_comes_with_the_nearest_valid_one() {
        let found = problem(json!({"cel": 1.0}));
        assert_eq!(found.key, "@cel");
        assert!(found.help.unwrap().contains("\"cell\""));
        let found = problem(json!({"cell": 1.0, "inner": {"thread": 3}}));
        assert_eq!(found.key, "@inner.thread");
        assert!(found.help.unwrap().contains("\"threads\""));
    }

    #[test]
    fn a_key_like_no_other_comes_with_all_valid_ones() {
        let found = problem(json!({"viscosity": 1.0}));
        assert!(found.help.unwrap().contains("cell, inner"));
    }

    #[test]
    fn a_wrong_type_is_said_with_its_key() {
        let found = problem(json!({"cell": "big"}));
        assert_eq!(found.key, "@cell");
        assert!(found.message.contains("big"), "{found}");
    }

    #[test]
    fn right_parameters_are_read() {
        let value = json!({"cell": 0.5, "inner": {"threads": 2}});
        let expected = Settings { cell: 0.5, inner: Inner { threads: 2 } };
        assert_eq!(read::<Settings>(value.as_object().unwrap()), Ok(expected));
    }
}
