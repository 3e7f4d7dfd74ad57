//! Judging: findings on results against their references.

use super::ValidationError;
use super::case::{Case, CaseRun, Check, Measure};
use super::measure;
use super::report::number;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;
use tremie_results::Signals;

/// Finding on a result against its reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// The check.
    pub check: String,
    /// Unit of the numbers.
    pub unit: String,
    /// The result; of a table the largest deviation.
    pub found: f64,
    /// Reference of the result.
    pub reference: Reference,
    /// The result is near enough to the reference.
    pub passed: bool,
    /// Of a table, each entry.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub entries: Vec<TableEntry>,
}

/// Reference of a result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// A number, and the largest relative deviation from it.
    Number(f64, f64),
    /// Bounds.
    Between(f64, f64),
    /// Many numbers, and the largest deviation from any of them.
    Table(f64),
}

/// An entry of a table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TableEntry {
    /// Abscissa in a picture.
    pub x: f64,
    /// Reference.
    pub expected: f64,
    /// Result.
    pub found: f64,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { check, unit, found, reference, passed, .. } = self;
        let verdict = if *passed { "ok" } else { "NOT OK" };
        write!(f, "{check} ")?;
        match reference {
            Reference::Number(expected, tolerance) => {
                let percent = 100.0 * (found / expected - 1.0);
                write!(
                    f,
                    "{} {unit}, reference {}, {percent:+.2} % (at most {} %): {verdict}",
                    number(*found),
                    number(*expected),
                    number(100.0 * tolerance)
                )
            }
            Reference::Between(low, high) => {
                write!(f, "{} {unit}, between {low} and {high}: {verdict}", number(*found))
            }
            Reference::Table(tolerance) => {
                let found = number(*found);
                write!(f, "largest deviation {found} {unit} (at most {tolerance}): {verdict}")
            }
        }
    }
}

/// Judges all checks of a run; `before` are the signals of the case's runs before it.
///
/// # Errors
/// A signal that is not there, a table that cannot be read.
pub fn all(
    case: &Case,
    run: &CaseRun,
    short: bool,
    signals: &Signals,
    before: &[(String, Signals)],
) -> Result<Vec<Finding>, ValidationError> {
    let place = case.folder.join(super::case::FILE);
    run.checks
        .iter()
        .map(|check| {
            let of = |text: String| {
                let message = format!("run \"{}\", check \"{}\": {text}", run.name, check.name);
                ValidationError::content(&place, message)
            };
            match &check.table {
                Some(file) => {
                    let path = case.folder.join(file);
                    let references = read_table(&path)?;
                    table(check, short, &references, signals).map_err(of)
                }
                None => scalar(check, short, signals, before).map_err(of),
            }
        })
        .collect()
}

fn scalar(
    check: &Check,
    short: bool,
    signals: &Signals,
    before: &[(String, Signals)],
) -> Result<Finding, String> {
    let measured = |measure: &Measure| {
        let Some(wanted) = &measure.run else { return measure::take(measure, signals) };
        let other = before.iter().find(|(name, _)| name == wanted);
        let (_, other) = other.ok_or_else(|| format!("the run \"{wanted}\" was not made"))?;
        measure::take(measure, other)
    };
    let mut found = measured(check.value.as_ref().ok_or("it has no value")?)?;
    if let Some(over) = &check.over {
        found /= measured(over)?;
    }
    if let Some(coarser) = &check.coarser {
        found += (found - measured(coarser)?) / 3.0;
    }
    let tolerance = check.tolerance(short);
    let (reference, passed) = match (check.expected, check.bounds(short)) {
        (Some(expected), _) => (
            Reference::Number(expected, tolerance),
            // A comparison with NaN is false, so a result that is no number never passes.
            (found - expected).abs() <= tolerance * expected.abs(),
        ),
        (None, Some([low, high])) => (Reference::Between(low, high), (low..=high).contains(&found)),
        (None, None) => return Err("it has no reference".into()),
    };
    let (check, unit) = (check.name.clone(), check.unit.clone());
    Ok(Finding { check, unit, found, reference, passed, entries: Vec::new() })
}

/// A row of a table.
#[derive(Clone, Debug, Deserialize)]
struct ReferenceRow {
    signal: String,
    expected: f64,
    #[serde(default)]
    x: f64,
}

fn read_table(path: &Path) -> Result<Vec<ReferenceRow>, ValidationError> {
    let wrong = |error: csv::Error| ValidationError::content(path, error);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(wrong)?;
    reader.deserialize().collect::<Result<_, _>>().map_err(wrong)
}

fn table(
    check: &Check,
    short: bool,
    rows: &[ReferenceRow],
    signals: &Signals,
) -> Result<Finding, String> {
    let mut entries = Vec::new();
    for ReferenceRow { signal, expected, x } in rows {
        let last = signals.column(signal)?.last().copied().ok_or("the run has no windows")?;
        entries.push(TableEntry { x: *x, expected: *expected, found: last * check.scale });
    }
    let far = |entry: &TableEntry| (entry.found - entry.expected).abs();
    // A value that is not a number is the farthest of all.
    let worst =
        entries.iter().map(far).fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
    let tolerance = check.tolerance(short);
    Ok(Finding {
        check: check.name.clone(),
        unit: check.unit.clone(),
        found: worst,
        reference: Reference::Table(tolerance),
        passed: worst <= tolerance,
        entries,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) -> Check {
        toml::from_str(text).unwrap()
    }

    fn signals() -> Signals {
        let columns = [
            ("a.b".to_string(), vec![1.0, 3.0]),
            ("a.c".to_string(), vec![0.0, 1.5]),
            ("a.nan".to_string(), vec![0.0, f64::NAN]),
        ];
        Signals { times: vec![0.0, 1.0], columns: columns.into(), ..Signals::default() }
    }

    #[test]
    fn a_ratio_is_held_against_a_number() {
        let text = r#"
            name = "ratio"
            value = { signal = "a.b", take = "last" }
            over = { signal = "a.c", take = "last" }
            expected = 2.02
            tolerance = 0.01
            short_tolerance = 0.005"#;
        let long = scalar(&check(text), false, &signals(), &[]).unwrap();
        assert!(long.passed && long.found == 2.0, "{long}");
        assert!(!scalar(&check(text), true, &signals(), &[]).unwrap().passed);
    }

    #[test]
    fn a_result_is_carried_on_to_cells_of_size_zero() {
        let text = r#"
            name = "limit"
            value = { signal = "a.b", take = "last" }
            coarser = { signal = "a.b", take = "last", run = "coarse" }
            expected = 2.0
            tolerance = 1e-12"#;
        // 2 + h^2, of cells of 1 and 2.
        let column = ("a.b".to_string(), vec![6.0]);
        let coarse = Signals { times: vec![0.0], columns: [column].into(), ..Signals::default() };
        let before = [("coarse".to_string(), coarse)];
        let found = scalar(&check(text), false, &signals(), &before).unwrap();
        assert!(found.passed && found.found == 2.0, "{found}");
    }

    #[test]
    fn a_run_is_held_against_one_before_it() {
        let text = r#"
            name = "ratio"
            value = { signal = "a.b", take = "last" }
            over = { run = "first", signal = "a.b", take = "first" }
            expected = 3.0
            tolerance = 0.0"#;
        let before = [("first".to_string(), signals())];
        assert!(scalar(&check(text), false, &signals(), &before).unwrap().passed);
        let error = scalar(&check(text), false, &signals(), &[]).unwrap_err();
        assert!(error.contains("\"first\" was not made"), "{error}");
    }

    #[test]
    fn not_a_number_never_passes() {
        for reference in ["expected = 1.0", "between = [-1e9, 1e9]"] {
            let text = format!(
                "name = \"x\"\nvalue = {{ signal = \"a.nan\", take = \"last\" }}\n{reference}\ntolerance = 1e9"
            );
            assert!(!scalar(&check(&text), false, &signals(), &[]).unwrap().passed);
        }
        let row = |signal: &str| ReferenceRow { signal: signal.into(), expected: 1.5, x: 0.0 };
        let check = check("name = \"t\"\ntable = \"t.csv\"\ntolerance = 9.0");
        assert!(table(&check, false, &[row("a.c"), row("a.b")], &signals()).unwrap().passed);
        assert!(!table(&check, false, &[row("a.nan"), row("a.b")], &signals()).unwrap().passed);
    }
}
