//! Tables of a study: `runs.csv` and `runs.parquet` with the results, `times.csv` with wall times.

use super::StudyError;
use super::axes::value_text;
use super::columns::StudyColumn;
use super::contents::StudyContents;
use super::folder::{RunOutcome, StudyFolder};
use super::parquet_table::parquet_table;
use super::runs::StudyRun;
use tremie_results::{SIGNALS, Signals};

/// The table of runs.
pub const TABLE: &str = "runs.csv";
/// The same table with types.
const TYPED_TABLE: &str = "runs.parquet";
/// The table of wall times. They differ from one time to the next, and so stand apart.
pub const TIMES: &str = "times.csv";

/// Results of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunResults {
    /// Status, as `completed`.
    pub status: String,
    /// Number of each column; `None` where the run has none.
    pub numbers: Vec<Option<f64>>,
    /// Wall time of its windows [s].
    pub wall_time: Option<f64>,
}

impl RunResults {
    /// The results of a run in its folder.
    pub fn read(
        folder: &StudyFolder,
        run: &StudyRun,
        columns: &[StudyColumn],
        outcome: RunOutcome,
    ) -> Self {
        let signals = match outcome.is_done() {
            true => Signals::read(&folder.of_run(run).join(SIGNALS)).ok(),
            // The numbers of half a run would stand among those of whole ones.
            false => None,
        };
        let number = |column: &StudyColumn| column.measure(signals.as_ref()?);
        let numbers = columns.iter().map(number).collect();
        Self { status: outcome.status, numbers, wall_time: outcome.wall_time }
    }
}

/// Writes all tables anew, with a row for each run that has ended, in the order of the points.
///
/// # Errors
/// If the disk refuses.
pub fn write_tables(
    folder: &StudyFolder,
    contents: &StudyContents,
    columns: &[StudyColumn],
    runs: &[StudyRun],
    results: &[Option<RunResults>],
) -> Result<(), StudyError> {
    let at = |name: &str| folder.path().join(name);
    let wrong = |name: &str, error: csv::Error| StudyError::Io {
        path: at(name),
        error: std::io::Error::from(error),
    };
    let table = results_table(contents, columns, runs, results);
    folder.write(TABLE, &table.map_err(|error| wrong(TABLE, error))?)?;
    let rows: Vec<_> = ended(runs, results).collect();
    let typed = parquet_table(contents, columns, &rows).map_err(|error| StudyError::Io {
        path: at(TYPED_TABLE),
        error: std::io::Error::other(error),
    })?;
    folder.write(TYPED_TABLE, &typed)?;
    let times = times_table(runs, results).map_err(|error| wrong(TIMES, error))?;
    folder.write(TIMES, &times)
}

fn results_table(
    contents: &StudyContents,
    columns: &[StudyColumn],
    runs: &[StudyRun],
    results: &[Option<RunResults>],
) -> Result<Vec<u8>, csv::Error> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let text = |text: &str| text.to_string();
    let heads = ["point", "seed"].map(text).into_iter().chain(contents.keys().map(text));
    let heads = heads.chain(["run", "status"].map(text));
    table.write_record(heads.chain(columns.iter().map(StudyColumn::heading)))?;
    for (run, results) in ended(runs, results) {
        let begin = [run.point.to_string(), seed_text(run)];
        let cells = begin.into_iter().chain(run.values.iter().map(value_text));
        let cells = cells.chain([run.name.clone(), results.status.clone()]);
        let numbers = results.numbers.iter().map(|number| number_text(*number));
        table.write_record(cells.chain(numbers))?;
    }
    table.into_inner().map_err(|error| error.into_error().into())
}

fn times_table(runs: &[StudyRun], results: &[Option<RunResults>]) -> Result<Vec<u8>, csv::Error> {
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(["point", "seed", "run", "wall_time [s]"])?;
    for (run, results) in ended(runs, results) {
        let time = number_text(results.wall_time);
        table.write_record([run.point.to_string(), seed_text(run), run.name.clone(), time])?;
    }
    table.into_inner().map_err(|error| error.into_error().into())
}

/// The runs that have ended, with their results.
fn ended<'a>(
    runs: &'a [StudyRun],
    results: &'a [Option<RunResults>],
) -> impl Iterator<Item = (&'a StudyRun, &'a RunResults)> {
    runs.iter().zip(results).filter_map(|(run, results)| Some((run, results.as_ref()?)))
}

fn seed_text(run: &StudyRun) -> String {
    run.seed.map_or(String::new(), |seed| seed.to_string())
}

/// A number as it reads back equal; nothing for none.
fn number_text(number: Option<f64>) -> String {
    // As `signals.csv` has them.
    number.and_then(serde_json::Number::from_f64).map_or(String::new(), |n| n.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_equal_and_nothing_stays_empty() {
        for value in [0.1, 1e-9, -2.5e300, 1.0 / 3.0] {
            assert_eq!(number_text(Some(value)).parse(), Ok(value));
        }
        assert_eq!(
            (number_text(None), number_text(Some(f64::NAN))),
            (String::new(), String::new())
        );
    }
}
