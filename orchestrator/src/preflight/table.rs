//! Findings as a person reads them.

use super::{JudgedFinding, count};
use crate::plan::bytes;
use tremie_messages::{Finding, Verdict};
use tremie_results::text_columns;

/// A table of all findings.
pub fn table(findings: &[JudgedFinding]) -> Vec<String> {
    let row = |judged: &JudgedFinding| {
        let JudgedFinding { component, finding } = judged;
        let remark = match finding.verdict {
            Verdict::Ok => finding.why.clone(),
            _ => "see below".into(),
        };
        let verdict = finding.verdict.name().to_string();
        vec![component.clone(), finding.quantity.clone(), value(finding), verdict, remark]
    };
    let titles = ["of", "quantity", "value", "verdict", "remark"];
    text_columns(&titles, findings.iter().map(row).collect())
}

/// Of each finding with a verdict, why, and what to do.
pub fn sentences(findings: &[JudgedFinding], verdict: Verdict) -> Vec<String> {
    let sentence = |judged: &JudgedFinding| {
        let JudgedFinding { component, finding } = judged;
        let Finding { quantity, why, remedy, .. } = finding;
        let name = verdict.name();
        let remedy =
            if remedy.is_empty() { String::new() } else { format!("\n  remedy: {remedy}") };
        format!("{name}: {component}: {quantity} is {}: {why}{remedy}", value(finding))
    };
    findings.iter().filter(|judged| judged.finding.verdict == verdict).map(sentence).collect()
}

/// Number of findings of each verdict, in a line.
pub fn total(findings: &[JudgedFinding]) -> String {
    let of = |verdict: Verdict| format!("{} {}", count(findings, verdict), verdict.name());
    format!("findings: {}, {}, {}", of(Verdict::Ok), of(Verdict::Doubtful), of(Verdict::Wrong))
}

fn value(finding: &Finding) -> String {
    match finding.unit.as_str() {
        "B" => bytes(finding.value as u64),
        _ => finding.value_text(),
    }
}
