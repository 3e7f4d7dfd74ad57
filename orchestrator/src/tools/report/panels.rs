//! Panels of a report: groups of signals of one kind, and their order.

use super::{Report, Run};
use std::collections::BTreeMap;

/// Curves of one panel at most; more of a kind go on in the next.
const CURVES: usize = 6;

/// A panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Kind that its signals have in common: `pressure`, `momentum`.
    pub title: String,
    /// SI unit of its values.
    pub unit: String,
    /// Its curves, in SI units.
    pub curves: Vec<PanelCurve>,
}

/// A signal of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelCurve {
    /// Name in the legend.
    pub name: String,
    /// Time [s] and value.
    pub points: Vec<(f64, f64)>,
}

/// True if a signal was asked for: by its own name, or by a group that it belongs to.
pub fn begins(signal: &str, wanted: &str) -> bool {
    signal.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '_']))
}

/// Parts of a signal's name.
struct SignalName<'a> {
    /// Probe or part: `beneath`, `valve`; empty for the whole component.
    of: &'a str,
    /// Quantity, without axis.
    kind: &'a str,
    /// `x`, `y`, `z`, or nothing.
    axis: &'a str,
}

/// `fluid.beneath.velocity_x` was measured at `beneath`, is a `velocity`, along `x`.
fn place(signal: &str) -> SignalName<'_> {
    let within = signal.split_once('.').map_or(signal, |(_, rest)| rest);
    let (of, what) = within.rsplit_once('.').unwrap_or(("", within));
    match what.rsplit_once('_') {
        Some((kind, axis @ ("x" | "y" | "z"))) => SignalName { of, kind, axis },
        _ => SignalName { of, kind: what, axis: "" },
    }
}

/// Sorts the signals of runs into panels: those of probes and parts first, then those of whole
/// components.
pub fn sort(runs: &[Run], wanted: &[String]) -> Report {
    let mut constant = Vec::new();
    let mut groups: BTreeMap<(bool, String, String, String), Vec<PanelCurve>> = BTreeMap::new();
    for name in wanted_names(runs, wanted) {
        let with = || runs.iter().filter_map(|run| Some((run, run.signals.columns.get(&name)?)));
        let changes = |values: &[f64]| values.iter().any(|value| *value != values[0]);
        let unit = unit_of(runs, &name);
        if !with().any(|(_, values)| changes(values)) {
            let first = with().find_map(|(_, values)| values.first().copied());
            constant.extend(first.map(|value| (name.clone(), value, unit)));
            continue;
        }
        let SignalName { of, kind, axis } = place(&name);
        // A component's signals of the whole are not mixed with another component's of the same
        // name.
        let component = if of.is_empty() { name.split('.').next().unwrap_or("") } else { "" };
        // The order of keys is that of panels: `false` first, so probes and parts come first.
        let key = (of.is_empty(), component.to_string(), kind.to_string(), unit);
        let curves = with().map(|(run, values)| PanelCurve {
            name: legend(&[of, axis], (runs.len() > 1).then_some(&run.name), kind),
            points: run.signals.times.iter().copied().zip(values.iter().copied()).collect(),
        });
        groups.entry(key).or_default().extend(curves);
    }
    let panels = groups.into_iter().flat_map(|((_, component, kind, unit), curves)| {
        let title = [component.as_str(), &kind.replace('_', " ")].join(" ").trim().to_string();
        let panel = move |part: &[PanelCurve]| Panel {
            title: title.clone(),
            unit: unit.clone(),
            curves: part.to_vec(),
        };
        curves.chunks(CURVES).map(panel).collect::<Vec<_>>()
    });
    Report { panels: panels.collect(), constant, ..Report::default() }
}

/// All signals that any run has, in order; with `wanted`, those that begin with one of these names.
pub(super) fn wanted_names(runs: &[Run], wanted: &[String]) -> Vec<String> {
    let all = runs.iter().flat_map(|run| run.signals.columns.keys());
    let is_wanted =
        |name: &&String| wanted.is_empty() || wanted.iter().any(|wanted| begins(name, wanted));
    let mut names: Vec<String> = all.filter(is_wanted).cloned().collect();
    names.sort();
    names.dedup();
    names
}

/// Unit of a signal, from the first run that tells it.
pub(super) fn unit_of(runs: &[Run], name: &str) -> String {
    let unit = runs.iter().find_map(|run| run.signals.units.get(name));
    unit.map_or("1", String::as_str).into()
}

fn legend(parts: &[&str], run: Option<&String>, kind: &str) -> String {
    let mut words: Vec<&str> = parts.iter().copied().filter(|part| !part.is_empty()).collect();
    if words.is_empty() && run.is_none() {
        words.push(kind);
    }
    let said = words.join(" ");
    match run {
        Some(run) if said.is_empty() => run.clone(),
        Some(run) => format!("{run}: {said}"),
        None => said,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_results::Signals;

    fn run(name: &str, signals: &[(&str, &str, [f64; 3])]) -> Run {
        let mut table = Signals { times: vec![0.0, 1.0, 2.0], ..Signals::default() };
        for (signal, unit, values) in signals {
            table.columns.insert((*signal).into(), values.to_vec());
            table.units.insert((*signal).into(), (*unit).into());
        }
        Run { name: name.into(), signals: table, profiles: Vec::new() }
    }

    const RISES: [f64; 3] = [0.0, 1.0, 3.0];

    #[test]
    fn signals_of_a_kind_share_a_panel() {
        let signals = [
            ("fluid.mass", "kg", RISES),
            ("fluid.beneath.pressure", "Pa", RISES),
            ("fluid.above.pressure", "Pa", RISES),
            ("grains.momentum_x", "kg m/s", RISES),
            ("grains.momentum_z", "kg m/s", RISES),
            ("fluid.momentum_z", "kg m/s", RISES),
            ("fluid.links", "1", [7.0; 3]),
        ];
        let report = sort(&[run("a", &signals)], &[]);
        let titles: Vec<&str> = report.panels.iter().map(|panel| panel.title.as_str()).collect();
        assert_eq!(titles, ["pressure", "fluid mass", "fluid momentum", "grains momentum"]);
        let legends: Vec<&str> = report.panels[0].curves.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(legends, ["above", "beneath"]);
        assert_eq!(report.panels[3].curves.len(), 2);
        assert_eq!(report.constant, [("fluid.links".to_string(), 7.0, "1".to_string())]);
    }

    #[test]
    fn runs_are_drawn_into_the_same_panels() {
        let with = |name| run(name, &[("grains.valve.lift", "m", RISES)]);
        let report = sort(&[with("slow"), with("fast")], &["grains.valve".into()]);
        assert_eq!(report.panels.len(), 1);
        assert_eq!(report.panels[0].curves[1].name, "fast: valve");
        assert!(sort(&[with("slow")], &["grains.val".into()]).panels.is_empty());
    }

    #[test]
    fn many_signals_take_several_panels() {
        let names: Vec<String> = (0..9).map(|i| format!("fluid.p{i}.pressure")).collect();
        let signals: Vec<_> = names.iter().map(|name| (name.as_str(), "Pa", RISES)).collect();
        let report = sort(&[run("a", &signals)], &[]);
        let counts: Vec<usize> = report.panels.iter().map(|panel| panel.curves.len()).collect();
        assert_eq!(counts, [6, 3]);
    }
}
