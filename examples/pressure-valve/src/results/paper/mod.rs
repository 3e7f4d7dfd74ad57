//! What Mutabaruka and Kamrin (*Comput. Part. Mech.* 5, 2018, section 3) say of their valves, held
//! against runs: `tremie valve --paper OUT...`.
//!
//! `valve_run` and `grain_run` read the numbers of a run, `series` finds runs that differ in one
//! quantity, `flow_statements` and `grain_statements` judge, `charts` draws what they judge.

mod charts;
mod flow_statements;
mod grain_run;
mod grain_statements;
mod series;
mod valve_run;

use serde::Serialize;
use tremie_results::{Chart, FinishedRun, text_columns};
use valve_run::ValveRun;

/// Widest cell of the table [characters].
const WIDTH: usize = 60;

/// A statement of the paper, and what runs show.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statement {
    /// Its number in the table.
    pub number: u32,
    /// The statement, in our words.
    pub says: &'static str,
    /// What the runs show; for one that is not reached what it would take.
    pub found: String,
    /// The judgement.
    pub verdict: StatementVerdict,
}

/// Judgement on a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StatementVerdict {
    /// The runs show it.
    Reproduced,
    /// They show something else.
    NotReproduced,
    /// None of them tells.
    NotReached,
}

impl StatementVerdict {
    fn words(self) -> &'static str {
        match self {
            Self::Reproduced => "reproduced",
            Self::NotReproduced => "not reproduced",
            Self::NotReached => "not reached",
        }
    }
}

/// What was found for a statement: words, and whether it is what the paper says. `Err` says which
/// runs it would take.
type Found = Result<(String, bool), &'static str>;

/// A statement with its judge.
type Judged = (u32, &'static str, fn(&[ValveRun]) -> Found);

/// All statements, judged by runs of valves; other runs are left out.
pub fn statements(runs: &[FinishedRun]) -> Vec<Statement> {
    let runs = valve_runs(runs);
    let all = flow_statements::ALL.iter().chain(grain_statements::ALL);
    let mut judged: Vec<_> = all.map(|statement| judge(statement, &runs)).collect();
    judged.sort_by_key(|statement| statement.number);
    judged
}

/// Charts of the series among the runs, beside what the paper says of them. Their titles begin with
/// the numbers of the statements.
pub fn charts(runs: &[FinishedRun]) -> Vec<Chart> {
    charts::of_both_valves(&valve_runs(runs))
}

/// Runs of valves; one that two studies have made counts once.
fn valve_runs(runs: &[FinishedRun]) -> Vec<ValveRun<'_>> {
    let mut known: Vec<ValveRun<'_>> = Vec::new();
    for run in runs.iter().filter_map(ValveRun::read) {
        if !known.iter().any(|other| other.is_same_as(&run)) {
            known.push(run);
        }
    }
    known
}

fn judge(&(number, says, judge): &Judged, runs: &[ValveRun]) -> Statement {
    let (found, verdict) = match judge(runs) {
        Ok((found, true)) => (found, StatementVerdict::Reproduced),
        Ok((found, false)) => (found, StatementVerdict::NotReproduced),
        Err(needs) => (format!("needs {needs}"), StatementVerdict::NotReached),
    };
    Statement { number, says, found, verdict }
}

/// The statements as a table of text.
pub fn statements_table(statements: &[Statement]) -> String {
    let rows = statements.iter().flat_map(|statement| {
        let [says, found] = [statement.says, &statement.found].map(|text| folded(text, WIDTH));
        (0..says.len().max(found.len())).map(move |line| {
            let of = |lines: &[String]| lines.get(line).cloned().unwrap_or_default();
            let first = |text: String| if line == 0 { text } else { String::new() };
            vec![
                first(statement.number.to_string()),
                of(&says),
                of(&found),
                first(statement.verdict.words().into()),
            ]
        })
    });
    let titles = ["", "the paper says", "these runs show", ""];
    text_columns(&titles, rows.collect()).iter().flat_map(|line| [line, "\n"]).collect()
}

/// A text in lines of at most so many characters, if its words are no longer.
fn folded(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().expect("there is a first line");
        if !last.is_empty() && last.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.into());
            continue;
        }
        if !last.is_empty() {
            last.push(' ');
        }
        last.push_str(word);
    }
    lines
}

/// Numbers of a series in words: `2.20, 3.55` with a factor.
fn listed(values: &[[f64; 2]], scale: f64, digits: usize) -> String {
    let each: Vec<_> = values.iter().map(|v| format!("{:.digits$}", scale * v[1])).collect();
    each.join(", ")
}

/// What the numbers of a series belong to: `1, 3, 6`.
fn over(values: &[[f64; 2]], scale: f64) -> String {
    let each: Vec<_> = values.iter().map(|v| trimmed(scale * v[0])).collect();
    each.join(", ")
}

/// A number with four digits at most.
fn trimmed(value: f64) -> String {
    format!("{}", format!("{value:.3e}").parse::<f64>().unwrap_or(value))
}
