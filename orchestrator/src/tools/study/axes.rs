//! Axes of a study: keys of the manifest with the rows of values that they take.

use super::file::{AxisTable, RangeTable};
use super::points::{Spacing, spread};
use serde_json::{Number, Value};
use tremie_messages::Problem;

/// Most values of a range.
const MOST_VALUES: u32 = 100_000;

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyAxis {
    /// Keys of the manifest.
    pub keys: Vec<String>,
    /// Values of the keys, row by row.
    pub rows: Vec<Vec<Value>>,
    /// The values have even ratios.
    pub is_log: bool,
    /// Key of the study file under which the rows stand.
    list: String,
    /// Each row stands there by itself.
    is_listed: bool,
}

impl StudyAxis {
    /// Reads an axis, of which `at` is the key in the study file. What is wrong goes to `problems`.
    pub fn read(table: &AxisTable, at: &str, problems: &mut Vec<Problem>) -> Self {
        let keys = match (&table.key, &table.keys) {
            (Some(key), None) => vec![key.clone()],
            (None, Some(keys)) if !keys.is_empty() => keys.clone(),
            _ => {
                let problem = Problem::new(at, "needs either a key or a list of keys");
                problems.push(problem.help("write key = \"run.until\", or keys = [\"…\", \"…\"]"));
                return Self::default();
            }
        };
        let mut axis = Self { keys, ..Self::default() };
        let forms = [
            ("values", table.values.is_some()),
            ("rows", table.rows.is_some()),
            ("range", table.range.is_some()),
            ("log", table.log.is_some()),
            ("random", table.random.is_some()),
        ];
        let mut given = forms.iter().filter(|(_, is_given)| *is_given).map(|(name, _)| *name);
        let (Some(list), None) = (given.next(), given.next()) else {
            let problem = Problem::new(at, "needs exactly one of values, rows, range, log, random");
            problems.push(problem.help("write values = [\"1 m/s\", \"2 m/s\"]"));
            return axis;
        };
        axis.list = format!("{at}.{list}");
        axis.is_listed = matches!(list, "values" | "rows");
        axis.is_log = list == "log";
        axis.rows = axis.rows_of(table, problems);
        axis.check_rows(problems);
        axis
    }

    fn rows_of(&self, table: &AxisTable, problems: &mut Vec<Problem>) -> Vec<Vec<Value>> {
        let one_each = |values: Vec<Value>| values.into_iter().map(|value| vec![value]).collect();
        if let Some(values) = &table.values {
            return one_each(values.clone());
        }
        if let Some(rows) = &table.rows {
            return rows.clone();
        }
        let range = table.range.as_ref().or(table.log.as_ref()).or(table.random.as_ref());
        let seed = table.random.as_ref().map(|random| random.seed.unwrap_or(1));
        let spacing = match (seed, self.is_log) {
            (Some(seed), _) => Spacing::Random(seed),
            (None, true) => Spacing::Log,
            (None, false) => Spacing::Even,
        };
        match range.map(|range| range_values(range, spacing)) {
            Some(Ok(values)) => one_each(values),
            Some(Err((message, help))) => {
                problems.push(Problem::new(&self.list, message).help(help));
                Vec::new()
            }
            None => Vec::new(),
        }
    }

    fn check_rows(&self, problems: &mut Vec<Problem>) {
        let count = self.keys.len();
        for (row, values) in self.rows.iter().enumerate() {
            if values.len() != count {
                let found = values.len();
                let message =
                    format!("found {found} values, expected one for each of {count} keys");
                problems.push(Problem::new(self.place(row, 0), message).help(match count {
                    1 => "write values = [a, b] for a single key",
                    _ => "write rows = [[a, b], [c, d]], a list for each point",
                }));
            } else if self.is_listed && self.rows[..row].contains(values) {
                let problem = Problem::new(self.place(row, 0), "the same values stand here twice");
                problems.push(problem.help("leave one of them out; `repeats` repeats points"));
            }
        }
        let is_told = problems.iter().any(|problem| problem.key == self.list);
        if self.rows.is_empty() && !is_told {
            let problem = Problem::new(&self.list, "has no values");
            problems.push(problem.help("leave the axis out, or give it a value"));
        }
    }

    /// Key of the study file under which a value stands.
    pub fn place(&self, row: usize, column: usize) -> String {
        match (self.is_listed, self.list.ends_with(".rows")) {
            (true, true) => format!("{}[{row}][{column}]", self.list),
            (true, false) => format!("{}[{row}]", self.list),
            (false, _) => self.list.clone(),
        }
    }

    /// The numbers of one of the keys, and their unit; `None` where they are none, or in several
    /// units.
    pub fn numbers(&self, column: usize) -> Option<(Vec<f64>, String)> {
        let all: Option<Vec<_>> =
            self.rows.iter().map(|row| number_and_unit(row.get(column)?)).collect();
        let all = all?;
        let unit = all.first().map(|(_, unit)| unit.clone()).unwrap_or_default();
        let is_one_unit = all.iter().all(|(_, other)| *other == unit);
        is_one_unit.then(|| (all.into_iter().map(|(number, _)| number).collect(), unit))
    }
}

/// A number with its unit, which is empty for a bare number.
pub fn number_and_unit(value: &Value) -> Option<(f64, String)> {
    match value {
        Value::Number(number) => Some((number.as_f64()?, String::new())),
        Value::String(text) => {
            let (number, unit) = text.trim().split_once(char::is_whitespace)?;
            let number = number.parse().ok().filter(|number: &f64| number.is_finite())?;
            Some((number, unit.trim().to_string()))
        }
        _ => None,
    }
}

/// Text of a value in tables and on command lines: words as they are, all else in TOML.
pub fn value_text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => toml_text(other),
    }
}

/// A value in TOML.
pub fn toml_text(value: &Value) -> String {
    toml::Value::try_from(value).map_or_else(|_| value.to_string(), |value| value.to_string())
}

/// The values of a range, or a sentence on what is wrong with it and a remedy.
fn range_values(range: &RangeTable, spacing: Spacing) -> Result<Vec<Value>, (String, String)> {
    let wrong = |message: &str, help: &str| (message.to_string(), help.to_string());
    let RangeTable { from: Some(from), to: Some(to), count: Some(count), seed } = range else {
        let help = "write { from = \"10 ms\", to = \"30 ms\", count = 3 }";
        return Err(wrong("needs from, to and count", help));
    };
    if seed.is_some() && !matches!(spacing, Spacing::Random(_)) {
        let help = "leave the seed out, or write random = { … }";
        return Err(wrong("only random values have a seed", help));
    }
    let help = "write numbers with a unit in quotes, as \"10 ms\", or bare numbers";
    let bound = |value: &Value| {
        number_and_unit(value).ok_or_else(|| {
            (format!("found {value}, expected a number, or a number with a unit"), help.to_string())
        })
    };
    let ((from, unit), (to, other)) = (bound(from)?, bound(to)?);
    if unit != other {
        let message = format!("from is in \"{unit}\", to in \"{other}\"");
        return Err((message, "give both in the same unit".into()));
    }
    let least = if matches!(spacing, Spacing::Random(_)) { 1 } else { 2 };
    if !(least..=MOST_VALUES).contains(count) {
        let message = format!("count is {count}, expected {least} to {MOST_VALUES}");
        return Err((message, "give another count; for a single value write values".into()));
    }
    if from == to {
        return Err(wrong("from and to are equal", "for a single value write values"));
    }
    if spacing == Spacing::Log && !(from > 0.0 && to > 0.0) {
        let help = "give bounds above zero, or write range";
        return Err(wrong("even ratios need bounds above zero", help));
    }
    let values = spread(spacing, from, to, *count);
    // Whole numbers stay whole: keys such as numbers of threads take no others.
    let is_whole = |value: &f64| value.fract() == 0.0 && value.abs() < 1e15;
    let all_whole = values.iter().all(is_whole);
    let written = |value: f64| match (unit.as_str(), all_whole) {
        ("", true) => Value::from(value as i64),
        ("", false) => Number::from_f64(value).map_or(Value::Null, Value::Number),
        (unit, _) => Value::String(format!("{value} {unit}")),
    };
    Ok(values.into_iter().map(written).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// The rows of an axis, or its problems.
    fn read(text: &str) -> Result<StudyAxis, Vec<Problem>> {
        let table: AxisTable = toml::from_str(text).unwrap();
        let mut problems = Vec::new();
        let axis = StudyAxis::read(&table, "axes[0]", &mut problems);
        if problems.is_empty() { Ok(axis) } else { Err(problems) }
    }

    #[test]
    fn an_axis_has_one_row_a_point() {
        let axis = read("key = 'a.b'\nvalues = ['1 m/s', '2 m/s']").unwrap();
        assert_eq!(axis.rows, [[json!("1 m/s")], [json!("2 m/s")]]);
        assert_eq!(
            (axis.numbers(0), axis.place(1, 0).as_str()),
            (Some((vec![1.0, 2.0], "m/s".into())), "axes[0].values[1]")
        );
        let axis = read("keys = ['a', 'b']\nrows = [[0.3, true], [0.1, false]]").unwrap();
        assert_eq!(axis.rows[1], [json!(0.1), json!(false)]);
        assert_eq!((axis.numbers(1), axis.place(1, 1).as_str()), (None, "axes[0].rows[1][1]"));
        let axis = read("key = 'a'\nrange = { from = '10 ms', to = '30 ms', count = 3 }").unwrap();
        assert_eq!(axis.rows, [[json!("10 ms")], [json!("20 ms")], [json!("30 ms")]]);
        let axis = read("key = 'a'\nlog = { from = 1, to = 100, count = 3 }").unwrap();
        assert_eq!(
            (axis.rows, axis.is_log),
            (vec![vec![json!(1)], vec![json!(10)], vec![json!(100)]], true)
        );
        let random = || read("key = 'a'\nrandom = { from = 0, to = 1, count = 4, seed = 3 }");
        assert_eq!((random().unwrap().rows.len(), random()), (4, random()));
    }

    #[test]
    fn a_wrong_axis_is_refused_with_its_place() {
        for (text, key, words) in [
            ("values = [1]", "axes[0]", "either a key"),
            ("key = 'a'\nkeys = ['b']\nvalues = [1]", "axes[0]", "either a key"),
            ("key = 'a'", "axes[0]", "exactly one of"),
            ("key = 'a'\nvalues = []", "axes[0].values", "no values"),
            ("key = 'a'\nvalues = [1, 2, 1]", "axes[0].values[2]", "twice"),
            ("keys = ['a', 'b']\nrows = [[1, 2], [1]]", "axes[0].rows[1][0]", "found 1 values"),
            ("key = 'a'\nrange = { from = 1, to = 2 }", "axes[0].range", "needs from"),
            (
                "key = 'a'\nrange = { from = '1 s', to = '2 ms', count = 3 }",
                "axes[0].range",
                "in \"ms\"",
            ),
            (
                "key = 'a'\nrange = { from = 'x', to = '2 ms', count = 3 }",
                "axes[0].range",
                "found \"x\"",
            ),
            ("key = 'a'\nrange = { from = 1, to = 2, count = 1 }", "axes[0].range", "count is 1"),
            ("key = 'a'\nlog = { from = 0, to = 2, count = 3 }", "axes[0].log", "above zero"),
            ("key = 'a'\nlog = { from = 1, to = 2, count = 3, seed = 1 }", "axes[0].log", "seed"),
        ] {
            let problems = read(text).unwrap_err();
            assert_eq!(problems.len(), 1, "{text}: {problems:?}");
            let Problem { key: found, message, help } = &problems[0];
            assert!(found == key && message.contains(words) && help.is_some(), "{problems:?}");
        }
    }

    #[test]
    fn values_are_written_as_the_command_line_takes_them() {
        assert_eq!(toml_text(&json!("1 m/s")), "\"1 m/s\"");
        assert_eq!(toml_text(&json!(["0 m/s", 2])), "[\"0 m/s\", 2]");
        assert_eq!(toml_text(&json!({"pressure": "1 Pa"})), "{ pressure = \"1 Pa\" }");
        assert_eq!(
            (value_text(&json!("1 m/s")), value_text(&json!(0.25))),
            ("1 m/s".into(), "0.25".into())
        );
    }
}
