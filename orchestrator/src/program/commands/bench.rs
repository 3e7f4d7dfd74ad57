//! `tremie bench`: speed of the parts of the program on this machine.

use super::WRONG_INPUT;
use crate::program::cli::BenchArgs;
use crate::tools::bench::{BenchmarkPlan, BenchmarkRow, benchmarks, measure};

use crate::terminal::standard::{answer, complain, is_lost};
use std::process::ExitCode;
use tremie_results::text_columns;
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes};

/// `tremie bench`: a table, or one JSON document a line.
pub fn bench(arguments: &BenchArgs) -> ExitCode {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut threads = arguments.threads.clone();
    if threads.is_empty() {
        threads.extend([1, cores]);
        // On a machine of one core.
        threads.dedup();
    }
    let plan = BenchmarkPlan {
        words: arguments.words.clone(),
        sizes: BenchmarkSizes { threads, edge: arguments.edge },
        repeats: arguments.repeats,
        seconds: arguments.seconds,
    };
    let cases = benchmarks(&plan);
    if cases.is_empty() {
        complain(format_args!("error: no case has the words {}", plan.words.join(", ")));
        return WRONG_INPUT.into();
    }
    if arguments.list {
        cases.iter().for_each(|case| answer(name(case)));
        return ExitCode::SUCCESS;
    }
    if !arguments.json {
        answer(format_args!("{cores} cores; median of {}, least and greatest\n", plan.repeats));
    }
    let mut whole = true;
    for case in &cases {
        // Measuring takes minutes, and there is no reader.
        if is_lost() {
            break;
        }
        match measure(case, &plan) {
            Ok(rows) if arguments.json => rows.iter().for_each(json),
            Ok(rows) => table(&name(case), &rows),
            Err(error) => {
                complain(format_args!("error: {}: {error}", name(case)));
                whole = false;
            }
        }
    }
    if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn name(case: &Benchmark) -> String {
    match case.threads {
        0 => case.name.clone(),
        1 => format!("{}, 1 thread", case.name),
        threads => format!("{}, {threads} threads", case.name),
    }
}

fn json(row: &BenchmarkRow) {
    answer(serde_json::to_string(row).expect("plain numbers have a form in JSON"));
}

fn table(name: &str, rows: &[BenchmarkRow]) {
    answer(name);
    let line = |row: &BenchmarkRow| {
        let [least, greatest] = row.range.map(number);
        let share = row.share.map_or(String::new(), |share| {
            let traffic = row.quantity.traffic.unwrap_or(f64::NAN);
            format!("{traffic:.0} B each, {:.0} % of the bandwidth in place", 100.0 * share)
        });
        let quantity = &row.quantity;
        let unit = if quantity.unit == "1" { "" } else { quantity.unit };
        let value = format!("{} {unit}", number(row.median));
        vec![quantity.name.clone(), value, format!("{least} to {greatest}"), share]
    };
    let lines = text_columns(&["", "", "", ""], rows.iter().map(line).collect());
    lines.iter().skip(1).for_each(answer);
}

/// Four digits.
fn number(value: f64) -> String {
    match value.abs() {
        size if size >= 1000.0 => format!("{value:.0}"),
        size if size >= 100.0 => format!("{value:.1}"),
        size if size >= 10.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    }
}
