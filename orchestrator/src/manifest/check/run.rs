//! Checks of `[run]`, `[outputs]` and `[[stop_when]]`.

use super::super::document::{CheckpointTable, Document, OutputsTable, RunTable, StopTable};
use super::super::path;
use super::super::read::Findings;
use super::super::spec::{Checkpoints, Limit, Outputs, RunOptions, START_WITHIN, StopCondition};
use std::num::NonZeroU64;
use tremie_messages::units::{LONGEST_WAIT, Time};
use tremie_sdk::parameters::nearest;

pub(super) fn run(table: &RunTable, findings: &mut Findings) -> Option<RunOptions> {
    let until = findings.positive(&table.until, "run", "until");
    let deadline = wait(&table.deadline, "deadline", findings);
    // The resolved manifest leaves it open, as it does threads: it belongs to the machine.
    let start_within = table.start_within.or(Some(Time(START_WITHIN)));
    let start_within = wait(&start_within, "start_within", findings);
    let checkpoints = checkpoints(table.checkpoints.as_ref(), findings);
    Some(RunOptions {
        until: until?,
        schedule: table.schedule?,
        deadline: deadline?,
        start_within: start_within?,
        seed: table.seed?,
        checkpoints: checkpoints?,
    })
}

fn checkpoints(table: Option<&CheckpointTable>, findings: &mut Findings) -> Option<Checkpoints> {
    let usual = Checkpoints::default();
    let Some(table) = table else { return Some(usual) };
    let given = table.every.map(|_| findings.positive(&table.every, "run.checkpoints", "every"));
    let windows = table.windows.map(NonZeroU64::get);
    let every = match given {
        Some(time) => Some(time?),
        None => usual.every.filter(|_| windows.is_none()),
    };
    Some(Checkpoints { every, windows, keep: table.keep.unwrap_or(usual.keep) })
}

/// A wait of wall time: above zero, and short enough to be one.
fn wait(value: &Option<Time>, key: &str, findings: &mut Findings) -> Option<f64> {
    let seconds = findings.positive(value, "run", key)?;
    let most = LONGEST_WAIT.as_secs_f64();
    if seconds > most {
        let found = format!("found {seconds} s, expected at most {most} s (a day)");
        let help = "what takes longer than that has hung";
        findings.problem_with_help(&path::join("run", key), found, help);
        return None;
    }
    Some(seconds)
}

pub(super) fn outputs(table: &OutputsTable, findings: &mut Findings) -> Option<Outputs> {
    let frames = table.frames.filter(|time| findings.above_zero(*time, "outputs.frames"));
    let fields = table.fields.filter(|time| findings.above_zero(*time, "outputs.fields"));
    let signals = table.signals.filter(|time| findings.above_zero(*time, "outputs.signals"));
    if table.messages == Some(true) && table.record == Some(false) {
        let found = "found true, and outputs.record is false: messages are kept in the recording";
        findings.problem_with_help("outputs.messages", found, "set outputs.record = true");
    }
    Some(Outputs {
        // Unset only where `run.until` is wrong: its default is a part of that.
        frames: frames?.0,
        fields: fields.map(|time| time.0),
        signals: signals.map(|time| time.0),
        record: table.record?,
        messages: table.messages?,
    })
}

pub(super) fn stops(document: &Document, findings: &mut Findings) -> Option<Vec<StopCondition>> {
    let names: Vec<&str> = document.components.keys().map(String::as_str).collect();
    let tables = document.stop_when.iter().enumerate();
    let stops: Vec<_> = tables
        .map(|(i, table)| stop(table, &path::item("stop_when", i), &names, findings))
        .collect();
    stops.into_iter().collect()
}

fn stop(
    table: &StopTable,
    at: &str,
    components: &[&str],
    findings: &mut Findings,
) -> Option<StopCondition> {
    let signal = findings
        .required(&table.signal, at, "signal")
        .and_then(|text| signal(&text, at, components, findings));
    let limit = limit(table, at, findings);
    let after = table.after.filter(|time| findings.not_negative(*time, &path::join(at, "after")));
    let hold = table.hold.filter(|time| findings.not_negative(*time, &path::join(at, "hold")));
    let (component, signal) = signal?;
    Some(StopCondition { component, signal, limit: limit?, after: after?.0, hold: hold?.0 })
}

/// Splits `component.signal`. The signals are known only when components have described themselves.
fn signal(
    text: &str,
    at: &str,
    components: &[&str],
    findings: &mut Findings,
) -> Option<(String, String)> {
    let key = path::join(at, "signal");
    let Some((component, signal)) = text.split_once('.') else {
        findings.problem(
            &key,
            format!(
                "found \"{text}\", expected a component and its signal, as \"grains.max_speed\""
            ),
        );
        return None;
    };
    if !components.contains(&component)
        && !findings.is_unreadable(&path::join("components", component))
    {
        let message = format!("there is no component \"{component}\"");
        match nearest(component, components) {
            Some(near) => {
                findings.problem_with_help(&key, message, format!("did you mean \"{near}\"?"))
            }
            None => findings.problem_with_help(
                &key,
                message,
                format!("components: {}", components.join(", ")),
            ),
        }
        return None;
    }
    Some((component.to_string(), signal.to_string()))
}

fn limit(table: &StopTable, at: &str, findings: &mut Findings) -> Option<Limit> {
    match (table.below, table.above) {
        (Some(bound), None) => Some(Limit::Below(bound)),
        (None, Some(bound)) => Some(Limit::Above(bound)),
        (Some(_), Some(_)) => {
            findings.problem(
                &path::join(at, "above"),
                "found both below and above, expected one of them",
            );
            None
        }
        (None, None) => {
            let unreadable =
                ["below", "above"].iter().any(|key| findings.is_unreadable(&path::join(at, key)));
            if !unreadable {
                findings.problem_with_help(
                    at,
                    "missing: a bound, either \"below\" or \"above\"",
                    "add above = 1.0, say, in the signal's SI unit",
                );
            }
            None
        }
    }
}
