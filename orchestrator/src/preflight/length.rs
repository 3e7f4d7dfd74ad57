//! Number of steps of the run, with a guess of the wall time, and the causes of short steps.

use crate::manifest::Spec;
use crate::plan::{Plan, PlannedComponent};
use indicatif::HumanDuration;
use std::time::Duration;
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::start::Description;

/// Steps beyond which a run is long, and steps beyond which it does not end in practice.
const LONG: f64 = 1e8;
const ENDLESS: f64 = 1e10;
/// Wall time beyond which a run is doubtful [s].
pub const WEEK: f64 = 7.0 * 86_400.0;

/// Speed of a machine, for a guess before anything has run: least time of a window [s], cell
/// updates and grain steps a second [1/s]. `check --measure` measures it.
const WINDOW: f64 = 5e-6;
const CELLS: f64 = 1e8;
const GRAINS: f64 = 1e7;

/// A component and its description.
type Told<'a> = (&'a PlannedComponent, &'a Description);

/// The number of steps of the component that makes most, with a guess of the wall time.
pub(super) fn finding(spec: &Spec, plan: &Plan, descriptions: &[Description]) -> Option<Finding> {
    let all = plan.components.iter().zip(descriptions);
    // Some roles make the steps of another, and may bound them.
    let physics = all.clone().filter(|(component, _)| component.role.has_steps());
    let follower = all.clone().find(|(component, _)| component.role.steps_with().is_some());
    let most = physics.clone().max_by_key(|(component, _)| component.substeps)?;
    let windows = plan.windows as f64;
    let work: f64 = physics.clone().map(|(component, said)| work(component, said)).sum();
    let (steps, wall) = (windows * f64::from(most.0.substeps), windows * (WINDOW + work));
    let guess =
        format!("about {} at 5 us a window, 1e8 cells and 1e7 grains a second", human(wall));
    let why = format!(
        "{} s (run.until) in windows of {} s: {}; {guess}",
        short(spec.run.until),
        short(plan.window),
        reasons(spec, physics, (most, follower)).join(", and "),
    );
    let remedy = format!(
        "a shorter run.until, or longer steps of {}: {}",
        most.0.name,
        most.0.role.rules().longer_steps
    );
    let finding = Finding::new("steps of the run", steps, "1").because(guess);
    Some(finding.wrong_if(steps > ENDLESS, &why, &remedy).doubtful_if(
        steps > LONG || wall > WEEK,
        why,
        remedy,
    ))
}

/// Wall time that a component computes in a window, at a guess [s].
fn work(component: &PlannedComponent, said: &Description) -> f64 {
    let rate = match said.work.as_str() {
        "cell updates" => CELLS,
        "grain steps" => GRAINS,
        _ => return 0.0,
    };
    f64::from(component.substeps) * said.work_per_step / rate
}

/// Causes of short windows and steps: of the component that sets the window, and of the component
/// that makes most steps in it.
fn reasons<'a>(
    spec: &Spec,
    physics: impl Iterator<Item = Told<'a>>,
    (most, follower): (Told<'a>, Option<Told<'a>>),
) -> Vec<String> {
    let of = |(component, said): Told<'_>| {
        let name = &component.name;
        let fixed = spec.component(name).and_then(|own| own.sync_iter);
        let sync = fixed.map_or(String::new(), |n| format!(" (sync_iter = {n})"));
        let bound = follower.filter(|(follower, bound)| {
            follower.role.steps_with() == Some(component.role)
                && bound.step.is_some_and(|step| said.step.is_none_or(|own| step < own))
        });
        let limit = match (bound, said.step_limit.as_str()) {
            (Some((follower, said)), _) => {
                format!("as {} asks for: {}", follower.name, said.step_limit)
            }
            (None, "") => "it does not say why".into(),
            (None, limit) => limit.into(),
        };
        format!("{name} steps {} s{sync}: {limit}", short(component.step))
    };
    let longest = |step: Option<f64>| step.unwrap_or(0.0);
    let pace =
        physics.max_by(|a, b| longest(a.0.largest_step).total_cmp(&longest(b.0.largest_step)));
    let other = pace.filter(|(component, _)| component.name != most.0.name);
    [Some(most), other].into_iter().flatten().map(of).collect()
}

/// A time [s] in words.
fn human(seconds: f64) -> String {
    const YEAR: f64 = 365.25 * 86_400.0;
    if seconds > 2.0 * YEAR {
        format!("{} years", short((seconds / YEAR).round()))
    } else {
        HumanDuration(Duration::from_secs_f64(seconds)).to_string()
    }
}
