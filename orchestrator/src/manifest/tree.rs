//! TOML text to a tree of plain values, with the place of each.

use super::hints::syntax_hint;
use super::path;
use super::source::{KeyPlace, Source};
use serde_json::{Map, Number, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};
use tremie_messages::Problem;

/// Reads the source's text. Syntax errors become problems, up to one that spoils the rest; where there
/// are none, all values come back, with places noted in `source`.
pub(super) fn read(source: &mut Source, problems: &mut Vec<Problem>) -> Value {
    let text = source.text.clone();
    let (table, errors) = DeTable::parse_recoverable(&text);
    for error in errors {
        problems.push(syntax(&error, source));
        // A list or a text without its end takes in all that follows: none of that is wrong by itself.
        if ["array", "inline table", "string,"].iter().any(|word| error.message().contains(word)) {
            break;
        }
    }
    if !problems.is_empty() {
        return Value::Object(Map::new());
    }
    Value::Object(Reader { source, problems }.table("", table.get_ref()))
}

/// A syntax error has no key: its line and column stand for one.
fn syntax(error: &Error, source: &mut Source) -> Problem {
    let at = error.span().unwrap_or(source.text.len()..source.text.len());
    let (line, column) = super::render::line_and_column(&source.text, at.start);
    let key = format!("line {line}, column {column}");
    let mut message = error.message().trim().replace('\n', ", ");
    if message == "duplicate key" {
        message = format!("duplicate key \"{}\"", source.text.get(at.clone()).unwrap_or_default());
    }
    source.put(key.clone(), KeyPlace::File { key: None, value: at });
    let problem = Problem::new(key, &message);
    match syntax_hint(&message) {
        Some(hint) => problem.help(hint),
        None => problem,
    }
}

struct Reader<'a> {
    source: &'a mut Source,
    problems: &'a mut Vec<Problem>,
}

impl Reader<'_> {
    fn table(&mut self, at: &str, table: &DeTable<'_>) -> Map<String, Value> {
        let mut map = Map::new();
        for (key, value) in table {
            let path = path::join(at, key.get_ref());
            let place = KeyPlace::File { key: Some(key.span()), value: value.span() };
            self.source.put(path.clone(), place);
            if let Some(value) = self.value(&path, value) {
                map.insert(key.get_ref().to_string(), value);
            }
        }
        map
    }

    fn value(&mut self, path: &str, value: &Spanned<DeValue<'_>>) -> Option<Value> {
        Some(match value.get_ref() {
            DeValue::String(text) => Value::String(text.to_string()),
            DeValue::Boolean(truth) => Value::Bool(*truth),
            DeValue::Integer(integer) => {
                let number =
                    i64::from_str_radix(integer.as_str(), integer.radix()).map(Number::from);
                return self.number(path, number.ok(), integer.as_str());
            }
            DeValue::Float(float) => {
                let number = float.as_str().parse().ok().and_then(Number::from_f64);
                return self.number(path, number, float.as_str());
            }
            DeValue::Datetime(date) => {
                self.problems
                    .push(Problem::new(path, format!("found the date {date}, which no key takes")));
                return None;
            }
            DeValue::Array(array) => Value::Array(
                (array.iter().enumerate())
                    .filter_map(|(index, entry)| {
                        let path = path::item(path, index);
                        self.source
                            .put(path.clone(), KeyPlace::File { key: None, value: entry.span() });
                        self.value(&path, entry)
                    })
                    .collect(),
            ),
            DeValue::Table(table) => Value::Object(self.table(path, table)),
        })
    }

    fn number(&mut self, path: &str, number: Option<Number>, text: &str) -> Option<Value> {
        if number.is_none() {
            let message = format!("found {text}, expected a finite number of moderate size");
            self.problems.push(Problem::new(path, message));
        }
        number.map(Value::Number)
    }
}
