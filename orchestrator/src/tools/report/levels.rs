//! Numbers of a report: where each signal stands at the end of its run, and how much it swings there.

use super::Run;
use super::panels::{unit_of, wanted_names};

/// Part of a run's time that counts as its end.
const END: f64 = 0.1;

/// A signal at the end of a run, in the signal's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Mean of its rows there.
    pub mean: f64,
    /// Their standard deviation; `None` of a single row.
    pub deviation: Option<f64>,
}

/// A signal at the ends of several runs.
#[derive(Clone, Debug, PartialEq)]
pub struct LevelRow {
    /// Name of the signal.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its level in each run; `None` where a run does not have it.
    pub of_runs: Vec<Option<Level>>,
}

/// Levels of all signals that change in some run or differ between runs, by name; with `wanted`, only of
/// those that begin with one of these names.
pub fn levels(runs: &[Run], wanted: &[String]) -> Vec<LevelRow> {
    let row = |name: String| LevelRow {
        unit: unit_of(runs, &name),
        of_runs: runs.iter().map(|run| level(run, &name)).collect(),
        name,
    };
    let names = wanted_names(runs, wanted).into_iter();
    names.filter(|name| is_told(runs, name)).map(row).collect()
}

/// True if a signal has more than one value in all runs together.
fn is_told(runs: &[Run], name: &str) -> bool {
    let mut values = runs.iter().filter_map(|run| run.signals.columns.get(name)).flatten();
    let first = values.next();
    values.any(|value| Some(value) != first)
}

fn level(run: &Run, name: &str) -> Option<Level> {
    let times = &run.signals.times;
    let values = run.signals.columns.get(name)?;
    let (begin, end) = (*times.first()?, *times.last()?);
    let from = end - END * (end - begin);
    let last = times.iter().zip(values).filter(|(time, _)| **time >= from);
    let last: Vec<f64> = last.map(|(_, value)| *value).collect();
    let count = last.len() as f64;
    let mean = last.iter().sum::<f64>() / count;
    let squares: f64 = last.iter().map(|value| (value - mean).powi(2)).sum();
    Some(Level { mean, deviation: (last.len() > 1).then(|| (squares / count).sqrt()) })
}

/// The same as a table for a spreadsheet, for runs of these names.
///
/// # Errors
/// What the writer of tables meets.
pub fn table(rows: &[LevelRow], runs: &[String]) -> Result<Vec<u8>, csv::Error> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let of_run = |run: &String| [format!("{run} mean"), format!("{run} deviation")];
    let head = ["signal", "unit"].map(String::from);
    table.write_record(head.into_iter().chain(runs.iter().flat_map(of_run)))?;
    for row in rows {
        let values = row.of_runs.iter().flat_map(|level| match level {
            Some(Level { mean, deviation }) => {
                [mean.to_string(), deviation.map_or(String::new(), |it| it.to_string())]
            }
            None => [String::new(), String::new()],
        });
        table.write_record([row.name.clone(), row.unit.clone()].into_iter().chain(values))?;
    }
    table.into_inner().map_err(|error| error.into_error().into())
}

/// The same for a person: lines of aligned columns, with the change from the first run to each other.
pub fn lines(rows: &[LevelRow], runs: &[String]) -> Vec<String> {
    let mut cells = vec![vec!["signal".to_string(), "unit".into()]];
    for (k, run) in runs.iter().enumerate() {
        cells[0].push(run.clone());
        cells[0].extend((k > 0).then(|| "change".into()));
    }
    for row in rows {
        let mut line = vec![row.name.clone(), row.unit.clone()];
        let first = row.of_runs[0];
        for (k, level) in row.of_runs.iter().enumerate() {
            line.push(level.map_or_else(|| "-".into(), |level| level.to_string()));
            line.extend((k > 0).then(|| change(first, *level)));
        }
        cells.push(line);
    }
    let width = |column: usize| cells.iter().map(|line| line[column].chars().count()).max();
    let widths: Vec<usize> = (0..cells[0].len()).filter_map(width).collect();
    let padded = |line: &Vec<String>| {
        let cells = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    cells.iter().map(padded).collect()
}

impl std::fmt::Display for Level {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { mean, deviation } = self;
        let mean_of = rounded(*mean, 4);
        match *deviation {
            None => write!(f, "{mean_of} (one row)"),
            Some(swing) if swing > 5e-5 * mean.abs() => {
                write!(f, "{mean_of} ± {}", rounded(swing, 2))
            }
            Some(_) => write!(f, "{mean_of}"),
        }
    }
}

/// A number with so many digits that count.
fn rounded(value: f64, digits: usize) -> String {
    let exponential = format!("{value:.*e}", digits - 1);
    let exact: f64 = exponential.parse().unwrap_or(value);
    match exact.abs() {
        size if size == 0.0 || (1e-3..1e6).contains(&size) => exact.to_string(),
        _ => exponential,
    }
}

/// Relative change between two levels, where both are there and it means something.
fn change(from: Option<Level>, to: Option<Level>) -> String {
    match (from, to) {
        // Beside a mean that is less than its swing, every change is large.
        (Some(from), Some(to)) if from.mean.abs() > from.deviation.unwrap_or(0.0) => {
            let percent = 100.0 * (to.mean / from.mean - 1.0);
            match percent.abs() < 1000.0 {
                true => format!("{percent:+.1} %"),
                false => "-".into(),
            }
        }
        _ => "-".into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_results::Signals;

    fn run(name: &str, columns: &[(&str, &[f64])]) -> Run {
        let rows = columns[0].1.len();
        let column = |(name, values): &(&str, &[f64])| (name.to_string(), values.to_vec());
        let signals = Signals {
            times: (0..rows).map(|k| k as f64).collect(),
            columns: columns.iter().map(column).collect(),
            units: [("f.pressure".to_string(), "Pa".to_string())].into(),
            cut: None,
        };
        Run { name: name.into(), signals, profiles: Vec::new() }
    }

    #[test]
    fn a_level_is_that_of_the_last_tenth() {
        let mut values = [0.0; 21];
        values[18..].copy_from_slice(&[1.0, 3.0, 2.0]);
        let rows = levels(&[run("a", &[("f.pressure", &values)])], &[]);
        let level = rows[0].of_runs[0].unwrap();
        assert_eq!(level.mean, 2.0);
        assert!((level.deviation.unwrap() - (2.0_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(lines(&rows, &["a".into()])[1], "f.pressure  Pa    2 ± 0.82");
    }

    #[test]
    fn runs_stand_beside_each_other_with_their_change() {
        let runs = [
            run("thin", &[("f.pressure", &[2.0; 21]), ("f.same", &[1.0; 21])]),
            run("thick", &[("f.pressure", &[2.5; 21]), ("f.more", &[0.0; 21])]),
        ];
        let rows = levels(&runs, &[]);
        let names: Vec<&str> = rows.iter().map(|row| row.name.as_str()).collect();
        assert_eq!(names, ["f.pressure"]);
        let said = lines(&rows, &["thin".into(), "thick".into()]);
        assert_eq!(said[0], "signal      unit  thin  thick  change");
        assert_eq!(said[1], "f.pressure  Pa    2     2.5    +25.0 %");
        let text = String::from_utf8(table(&rows, &["thin".into(), "thick".into()]).unwrap());
        let text = text.unwrap();
        assert!(text.starts_with("signal,unit,thin mean,thin deviation,thick mean,"), "{text}");
        assert!(text.contains("f.pressure,Pa,2,0,2.5,0"), "{text}");
    }

    #[test]
    fn a_single_row_and_a_mean_of_nothing_say_little() {
        let one = levels(&[run("few", &[("f.pressure", &[1.0, 2.0, 3.0])])], &[]);
        assert_eq!(lines(&one, &["few".into()])[1], "f.pressure  Pa    3 (one row)");
        let swings: Vec<f64> = (0..40).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let runs = [run("a", &[("f.pressure", &swings)]), run("b", &[("f.pressure", &[3.0; 40])])];
        let said = lines(&levels(&runs, &[]), &["a".into(), "b".into()]);
        assert!(said[1].ends_with("3  -"), "{said:?}");
    }

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        assert_eq!(rounded(0.221716, 4), "0.2217");
        assert_eq!(rounded(1.0e-7, 4), "1.000e-7");
        assert_eq!(rounded(-12345.6, 4), "-12350");
        assert_eq!(rounded(0.0, 2), "0");
    }
}
