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

/// Speed of a machine, for a guess before anything has run: least time of a window [s], and work a
/// second [1/s]: cell updates of a lattice, wet cells of a particle fluid and points of a gas in a
/// plane and in space
/// (one thread), and grain steps. `check --measure` measures it.
const WINDOW: f64 = 5e-6;
const CELLS: f64 = 1e8;
const WET_CELLS_IN_PLANE: f64 = 3e5;
const WET_CELLS_IN_SPACE: f64 = 1.2e5;
const GAS_IN_PLANE: f64 = 6e5;
const GAS_IN_SPACE: f64 = 2.5e5;
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
    let is_plane = spec.scene.domain.across.is_some();
    let rates = physics.clone().map(|(component, said)| (component, said, rate(said, is_plane)));
    let (wall, speeds) = wall_time(windows, rates);
    let steps = windows * f64::from(most.0.substeps);
    let guess = format!("about {} at 5 us a window{speeds}", human(wall));
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
    let is_short = spec.run.until < 0.9 * plan.window;
    let finding = finding.doubtful_if(
        is_short,
        format!(
            "run.until, {} s, is less than one window of {} s, and the run makes a whole one",
            short(spec.run.until),
            short(plan.window)
        ),
        "a longer run.until, or shorter steps",
    );
    Some(finding.wrong_if(steps > ENDLESS, &why, &remedy).doubtful_if(
        steps > LONG || wall > WEEK,
        why,
        remedy,
    ))
}

/// Work that a component does in a second, at a guess, and its name; `None` where there is no guess.
fn rate(said: &Description, is_plane: bool) -> Option<(f64, &'static str)> {
    match (said.work.as_str(), is_plane) {
        ("cell updates", _) => Some((CELLS, "cells")),
        ("wet cells", true) => Some((WET_CELLS_IN_PLANE, "wet cells (plane, one thread)")),
        ("wet cells", false) => Some((WET_CELLS_IN_SPACE, "wet cells (space, one thread)")),
        ("points of gas", true) => Some((GAS_IN_PLANE, "points of gas (plane, one thread)")),
        ("points of gas", false) => Some((GAS_IN_SPACE, "points of gas (space, one thread)")),
        ("grain steps", _) => Some((GRAINS, "grains")),
        _ => None,
    }
}

/// Wall time of so many windows at a guess [s], and the speeds that it counts with in words.
fn wall_time<'a>(
    windows: f64,
    rates: impl Iterator<Item = (&'a PlannedComponent, &'a Description, Option<(f64, &'static str)>)>,
) -> (f64, String) {
    let (mut window, mut speeds) = (WINDOW, Vec::new());
    for (component, said, rate) in rates {
        let Some((rate, what)) = rate else { continue };
        window += f64::from(component.substeps) * said.work_per_step / rate;
        speeds.push(format!("{} {what}", short(rate)));
    }
    let speeds = if speeds.is_empty() {
        String::new()
    } else {
        format!(", {} a second", speeds.join(" and "))
    };
    (windows * window, speeds)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wet_cell_of_particles_takes_longer_than_a_cell_of_a_lattice() {
        let said = |work: &str| Description { work: work.into(), ..Description::default() };
        let seconds = |work: &str, is_plane| 1.0 / rate(&said(work), is_plane).unwrap().0;
        assert!(seconds("wet cells", true) > 100.0 * seconds("cell updates", true));
        assert!(seconds("wet cells", false) > seconds("wet cells", true));
        assert_eq!(rate(&said("something else"), true), None);
    }
}
