//! The unit doctor: numbers of a run before it begins, each with a verdict and a remedy.
//!
//! A slip in a unit or a step gives a run that goes through and means nothing. Components bring
//! findings of their own ([`Description::findings`]). This room adds what only the whole can tell:
//! fit and number of steps, memory and disk, net inflow. `tremie check` and `tremie run` show all
//! of it, and the summary keeps it. A wrong number makes `tremie check` fail; a run goes on,
//! because its user may know better. When it is over, [`look_back`] judges its signals.

mod flow;
mod length;
mod machine;
mod resources;
mod steps;
mod table;

pub use length::WEEK;
pub use machine::Machine;
pub use table::{sentences, table, total};

use crate::manifest::Spec;
use crate::outputs::{JudgedFinding, Statistics};
use crate::plan::Plan;
use std::collections::BTreeMap;
use tremie_messages::start::Description;
use tremie_messages::{Limit, Verdict};

/// All findings about a run: first the components' own, in the order of the manifest, then findings
/// on the whole. `descriptions` are in the order of the plan.
pub fn examine(
    spec: &Spec,
    plan: &Plan,
    descriptions: &[Description],
    machine: &Machine,
) -> Vec<JudgedFinding> {
    let own = plan.components.iter().zip(descriptions).flat_map(|(component, description)| {
        description.findings.iter().map(|finding| JudgedFinding {
            component: component.name.clone(),
            finding: finding.clone(),
        })
    });
    let whole = steps::findings(spec, plan)
        .into_iter()
        .chain(length::finding(spec, plan, descriptions))
        .chain(flow::findings(&spec.scene))
        .chain(resources::findings(spec, plan, descriptions, machine))
        .map(JudgedFinding::of_whole);
    own.chain(whole).collect()
}

/// Findings on the signals of a run that is over: the greatest value of each for which a component,
/// by name, gave a limit.
pub fn look_back<'a>(
    components: impl Iterator<Item = (&'a str, &'a Description)>,
    signals: &BTreeMap<String, Statistics>,
) -> Vec<JudgedFinding> {
    let of = |(name, description): (&str, &'a Description)| {
        let judge = |limit: &Limit| {
            let told = signals.get(&format!("{name}.{}", limit.signal))?;
            // A signal that was never measured has no greatest value.
            let finding = told.max.is_finite().then(|| limit.judge(told.max, told.max_at))?;
            Some(JudgedFinding { component: name.into(), finding })
        };
        description.limits.iter().filter_map(judge).collect::<Vec<_>>()
    };
    components.flat_map(of).collect()
}

/// Number of findings with a verdict.
pub fn count(findings: &[JudgedFinding], verdict: Verdict) -> usize {
    findings.iter().filter(|judged| judged.finding.verdict == verdict).count()
}
