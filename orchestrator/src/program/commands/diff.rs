//! `tremie diff OUT1 OUT2`: compares two runs.

use super::{WRONG_INPUT, refuse_text};
use crate::program::cli::DiffArgs;
use crate::terminal::standard::answer;
use crate::terminal::{Style, Terminal};
use crate::tools::compare::{CompareError, compare_runs};
use serde_json::{Value, json};
use std::process::ExitCode;

/// `tremie diff`: success if the runs are equal.
pub fn diff(arguments: &DiffArgs) -> ExitCode {
    let mut terminal = Terminal::answering(Style::asked(false, arguments.json));
    let found = match compare_runs([&arguments.one, &arguments.other]) {
        Ok(found) => found,
        Err(CompareError::Manifest(errors)) => {
            return refuse_text(&errors, arguments.json, &terminal);
        }
        Err(error) => {
            terminal.fail(&error.to_string());
            return WRONG_INPUT.into();
        }
    };
    let is_equal = found.is_equal();
    if terminal.speaks_json() {
        let mut document = serde_json::to_value(&found).unwrap_or(Value::Null);
        document["event"] = "difference".into();
        terminal.event(document);
        let text = found.verdict();
        terminal.event(json!({"event": "end", "text": text, "equal": is_equal}));
    } else {
        found.lines().iter().for_each(answer);
    }
    ExitCode::from(u8::from(!is_equal))
}
