//! `VALIDATION.md`: all cases with their numbers, resolution, time and pictures.

use super::case::Case;
use super::judge::{Finding, Reference};
use super::record::{OfKind, Record, RunRecord, Verdicts};
use std::fmt::Write;
use std::path::Path;

/// The report on all cases; `folder` is where they lie, as a reader of the report sees it.
pub fn text(cases: &[(Case, Option<Record>)], folder: &Path) -> String {
    let mut out = String::from(HEAD);
    overview(&mut out, cases);
    for (case, record) in cases {
        section(&mut out, case, record.as_ref(), folder);
    }
    out
}

const HEAD: &str = "\
# Validation

Scenes whose result is known, run by manifest alone, each held against its reference. This page is written by
`cargo run --release -- validate`; each case has a folder with its manifest, the source of its reference and its
tolerances. Every number stands beside the resolution that gave it. Wall times are of the machine that made this page and
serve to compare cases with each other.

There are three kinds of checks. A *reference* holds a result against theory, experiment or other people's computations. A *trend* holds
it against a direction or an order that a source describes. A *record* keeps what was found before within bounds of our own; it
says nothing of being right. A failure whose cause is known stands, with its reason below the table of its case.

";

fn overview(out: &mut String, cases: &[(Case, Option<Record>)]) {
    out.push_str(
        "| case | references | trends | records | time |\n| --- | --- | --- | --- | --- |\n",
    );
    let mut all = Verdicts::default();
    for (case, record) in cases {
        let anchor = anchor(&case.title);
        let _ = match record {
            None => writeln!(out, "| [{}](#{anchor}) | not run | | | |", case.title),
            Some(record) => {
                let verdicts = record.verdicts(case);
                all.join(&verdicts);
                let wall: f64 = record.runs.iter().map(|run| run.wall_time).sum();
                let form = match (record.any_failed(), record.short) {
                    (true, _) => ", **a run failed**",
                    (false, true) => " (short form)",
                    (false, false) => "",
                };
                let [references, trends, records] = verdicts.of_kind.map(passed);
                writeln!(
                    out,
                    "| [{}](#{anchor}) | {references} | {trends} | {records} | {}{form} |",
                    case.title,
                    duration(wall)
                )
            }
        };
    }
    let [references, trends, records] = all.of_kind.map(passed);
    let _ = writeln!(out, "| all | {references} | {trends} | {records} | |");
}

/// Number of passed checks of all; empty if there are none.
fn passed(of_kind: OfKind) -> String {
    let OfKind { checks, passed } = of_kind;
    match (checks, passed) {
        (0, _) => String::new(),
        _ if passed == checks => format!("{passed} of {checks}"),
        _ => format!("**{passed} of {checks}**"),
    }
}

/// Anchor of a heading, as the usual renderers of Markdown make it.
fn anchor(title: &str) -> String {
    let lower = title.to_lowercase();
    let kept = lower.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

fn section(out: &mut String, case: &Case, record: Option<&Record>, folder: &Path) {
    let Case { name, title, source, about, pictures, .. } = case;
    let _ = write!(out, "\n## {title}\n\n");
    if !about.trim().is_empty() {
        let _ = write!(out, "{}\n\n", about.trim());
    }
    let _ =
        write!(out, "Reference: {source}. Case: [{name}]({}).\n\n", folder.join(name).display());
    let Some(record) = record else {
        out.push_str("Not run yet.\n");
        return;
    };
    out.push_str("| run | quantity | kind | result | reference | deviation | allowed |  |\n");
    out.push_str("| --- | --- | --- | --- | --- | --- | --- | --- |\n");
    for run in &record.runs {
        for finding in &run.findings {
            row(out, case, run, finding);
        }
        if let Some(why) = &run.failed {
            // The last line holds the cause. An unescaped bar would end the cell of the table.
            let last = why.lines().last().unwrap_or_default().replace('|', "\\|");
            let _ = writeln!(out, "| {} | the run failed: {last} | | | | | | **no** |", run.name);
        }
    }
    for run in &record.runs {
        for finding in run.findings.iter().filter(|finding| !finding.passed) {
            let check = case.check(&run.name, &finding.check);
            if let Some(why) = check.and_then(|check| check.stands.as_ref()) {
                let _ = write!(
                    out,
                    "\n{}, {}: the failure stands. {}\n",
                    run.name,
                    finding.check,
                    why.trim()
                );
            }
        }
    }
    out.push_str("\n| run | resolution | time |\n| --- | --- | --- |\n");
    for run in &record.runs {
        let shown: Vec<String> = run
            .resolution
            .iter()
            .map(|(name, value)| format!("{name} {}", number(*value)))
            .collect();
        let _ =
            writeln!(out, "| {} | {} | {} |", run.name, shown.join("; "), duration(run.wall_time));
    }
    for picture in pictures {
        let drawn = folder.join(name).join(format!("{}.svg", picture.file));
        let _ = write!(out, "\n![{}]({})\n", picture.title, drawn.display());
    }
}

fn row(out: &mut String, case: &Case, run: &RunRecord, finding: &Finding) {
    let Finding { check, unit, found, reference, passed, .. } = finding;
    let of_case = case.check(&run.name, check);
    let kind = of_case.and_then(|check| check.kind).unwrap_or_default().name();
    let verdict = match (passed, of_case.is_some_and(|check| check.stands.is_some())) {
        (true, _) => "ok",
        (false, true) => "**no**, stands",
        (false, false) => "**no**",
    };
    let with_unit = |value: f64| format!("{} {unit}", number(value)).trim_end().to_string();
    let (reference, deviation, allowed) = match reference {
        Reference::Number(expected, tolerance) => (
            with_unit(*expected),
            format!("{:+.2} %", 100.0 * (found / expected - 1.0)),
            format!("{} %", number(100.0 * tolerance)),
        ),
        Reference::Between(low, high) => {
            (format!("{} to {}", number(*low), with_unit(*high)), String::new(), String::new())
        }
        Reference::Table(tolerance) => {
            (format!("{} values", finding.entries.len()), with_unit(*found), with_unit(*tolerance))
        }
    };
    let result = if finding.entries.is_empty() { with_unit(*found) } else { "curve".into() };
    let name = &run.name;
    let _ = writeln!(
        out,
        "| {name} | {check} | {kind} | {result} | {reference} | {deviation} | {allowed} | {verdict} |"
    );
}

/// Five digits, without a tail of zeros.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    if !(1e-3..1e7).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let decimals = (4 - magnitude.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text,
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.0, "0"),
            (5.5795, "5.5795"),
            (128.0, "128"),
            (0.010619, "0.010619"),
            (2.5e-4, "2.5000e-4"),
            (16.5, "16.5"),
            (2_129_600.0, "2129600"),
        ];
        for (value, expected) in cases {
            assert_eq!(number(value), expected);
        }
    }

    #[test]
    fn headings_have_the_anchors_that_renderers_give() {
        assert_eq!(anchor("Cylinder in a channel, 2D-1"), "cylinder-in-a-channel-2d-1");
    }
}
