//! Fit of the components' steps into windows.

use crate::manifest::{ComponentSpec, Spec};
use crate::plan::TOLERANCE;
use crate::plan::{Plan, PlannedComponent};
use tremie_messages::Finding;
use tremie_messages::Role;
use tremie_messages::finding::short;

/// The ratio of window and step of each component that makes substeps.
pub(super) fn findings(spec: &Spec, plan: &Plan) -> Vec<Finding> {
    let physics = plan.components.iter().filter(|c| c.role != Role::Observer);
    let slower = |c: &&PlannedComponent| {
        c.largest_step.is_some_and(|step| step < plan.window * (1.0 - TOLERANCE))
    };
    physics.filter(slower).filter_map(|c| ratio(c, spec.component(&c.name)?, plan)).collect()
}

fn ratio(component: &PlannedComponent, spec: &ComponentSpec, plan: &Plan) -> Option<Finding> {
    let PlannedComponent { name, substeps, step, largest_step, .. } = component;
    let wanted = (*largest_step)?;
    let ratio = plan.window / wanted;
    let finding = Finding::new(format!("step ratio of {name}"), ratio, "1");
    let plural = if *substeps == 1 { "" } else { "s" };
    let becomes =
        format!("{name} makes {substeps} substep{plural} of {} s in a window", short(*step));
    if (step - wanted).abs() <= TOLERANCE * wanted {
        return Some(finding.because(becomes));
    }
    let becomes = format!("{becomes}, where it could make steps of {} s", short(wanted));
    // A step that the component chose itself is an upper bound, and loses nothing by being shorter.
    if spec.sync_iter.is_some() || !sets_step(spec) {
        return Some(finding.because(becomes));
    }
    let (whole, n) = (ratio.floor().max(1.0), substeps);
    Some(finding.doubtful_if(
        true,
        format!(
            "the steps that were set do not fit: {} s are {} steps of {} s; {n} steps of {} s are made instead",
            short(plan.window),
            short(ratio),
            short(wanted),
            short(*step)
        ),
        format!(
            "set the step of {name} to {} s for {n} substeps, or to {} s for {whole} if that is stable; or make the window {} s",
            short(*step),
            short(plan.window / whole),
            short(whole * wanted)
        ),
    ))
}

/// True if the manifest sets the step, which all built-in components call `time_step`.
fn sets_step(spec: &ComponentSpec) -> bool {
    spec.settings.contains_key("time_step")
}
