//! The unit doctor: numbers of a run before it begins, each with a verdict and a remedy.
//!
//! A slip in a unit or a step gives a run that goes through and means nothing. Components say what
//! they know of their own ([`Description::findings`]); here is what only the whole can tell: how
//! the steps fit and how many they are, whether machine and disk hold the run, what flows in and never out. `tremie check`
//! and `tremie run` show all of it, and the summary keeps it. A wrong number makes `tremie check`
//! fail; a run goes on, because its user may know better. When it is over, [`look_back`] judges what its signals were.

mod flow;
mod length;
mod machine;
pub mod measure;
mod resources;
mod steps;
mod table;

pub use machine::Machine;
pub use table::{sentences, table, total};

use crate::manifest::Spec;
use crate::outputs::Statistics;
use crate::plan::Plan;
use serde::Serialize;
use std::collections::BTreeMap;
use tremie_messages::start::Description;
use tremie_messages::{Finding, Limit, Verdict};

/// A finding and who made it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judged {
    /// The component, or [`WHOLE`].
    pub component: String,
    /// What it found.
    #[serde(flatten)]
    pub finding: Finding,
}

/// Who made findings about the run as a whole.
pub const WHOLE: &str = "run";

/// All findings about a run: those of its components, in the order of the manifest, then those of
/// the whole. `descriptions` are what the components said, in the order of the plan.
pub fn examine(
    spec: &Spec,
    plan: &Plan,
    descriptions: &[Description],
    machine: &Machine,
) -> Vec<Judged> {
    let own = plan.components.iter().zip(descriptions).flat_map(|(component, description)| {
        description
            .findings
            .iter()
            .map(|finding| Judged { component: component.name.clone(), finding: finding.clone() })
    });
    let whole = steps::findings(spec, plan)
        .into_iter()
        .chain(length::finding(spec, plan, descriptions))
        .chain(flow::findings(&spec.scene))
        .chain(resources::findings(&spec.scene, plan, descriptions, machine))
        .map(of_whole);
    own.chain(whole).collect()
}

/// What signals say of a run that is over: the greatest value of each for which a component, by name, gave a limit.
pub fn look_back<'a>(
    components: impl Iterator<Item = (&'a str, &'a Description)>,
    signals: &BTreeMap<String, Statistics>,
) -> Vec<Judged> {
    let of = |(name, description): (&str, &'a Description)| {
        let judge = |limit: &Limit| {
            let told = signals.get(&format!("{name}.{}", limit.signal))?;
            let finding = told.max.is_finite().then(|| limit.judge(told.max, told.max_at))?;
            Some(Judged { component: name.into(), finding })
        };
        description.limits.iter().filter_map(judge).collect::<Vec<_>>()
    };
    components.flat_map(of).collect()
}

/// A finding about the run as a whole.
pub fn of_whole(finding: Finding) -> Judged {
    Judged { component: WHOLE.into(), finding }
}

/// How many findings have a verdict.
pub fn count(findings: &[Judged], verdict: Verdict) -> usize {
    findings.iter().filter(|judged| judged.finding.verdict == verdict).count()
}
