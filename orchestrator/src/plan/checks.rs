//! Checks of a manifest that need the components' descriptions: stop conditions, injections, ports.

use super::{Described, Options};
use crate::manifest::Spec;
use tremie_messages::scene::{InletVelocity, Scene};
use tremie_messages::start::InjectionKind;
use tremie_messages::{Problem, Role};
use tremie_sdk::parameters::nearest;

/// Stop conditions must watch a signal that is there.
pub(super) fn stops(spec: &Spec, described: &[Described<'_>]) -> Vec<Problem> {
    let signals: Vec<String> = (described.iter())
        .flat_map(|(c, d)| {
            d.signals.iter().map(move |signal| format!("{}.{}", c.name, signal.name))
        })
        .collect();
    let signals: Vec<&str> = signals.iter().map(String::as_str).collect();
    let unknown = spec.stop_when.iter().enumerate().filter_map(|(i, stop)| {
        let name = format!("{}.{}", stop.component, stop.signal);
        (!signals.contains(&name.as_str())).then_some((i, name))
    });
    unknown
        .map(|(i, name)| {
            let problem = Problem::new(
                format!("stop_when[{i}].signal"),
                format!("there is no signal \"{name}\""),
            );
            suggest(problem, &name, &signals, "signals")
        })
        .collect()
}

/// Injections must name a component of the physics and a window of the run.
pub(super) fn injections(spec: &Spec, options: &Options, windows: u64) -> Vec<Problem> {
    let physics = spec.components.iter().filter(|component| component.role != Role::Observer);
    let names: Vec<&str> = physics.map(|component| component.name.as_str()).collect();
    let steps_with = |name: &str| {
        spec.components.iter().find(|c| c.name == name).and_then(|c| c.role.steps_with())
    };
    let mut problems = Vec::new();
    for (name, injection) in &options.injections {
        if !names.contains(&name.as_str()) {
            let problem = Problem::new(
                "--inject",
                format!("there is no component of the physics called \"{name}\""),
            );
            problems.push(suggest(problem, name, &names, "components"));
        }
        let of_substeps = [InjectionKind::SubstepMore, InjectionKind::SubstepLess];
        if of_substeps.contains(&injection.kind)
            && let Some(other) = steps_with(name)
        {
            let message = format!("{name} makes the substeps of the {other}, no number of its own");
            let help = format!("let the {other} make the fault");
            problems.push(Problem::new("--inject", message).help(help));
        }
        if injection.kind.is_of_message() && names.len() == 1 {
            let message =
                format!("{name} sends no messages in this run: nothing can be wrong with one");
            problems.push(Problem::new("--inject", message).help("hang, exit and kill need none"));
        }
        if injection.window == 0 || injection.window > windows {
            let window = injection.window;
            let message = format!("window {window} is none of the run's, 1 to {windows}");
            problems.push(Problem::new("--inject", message));
        }
    }
    problems
}

/// Inlets that take velocities of the fluid at open faces need a fluid that sends them and grains
/// that take them.
pub(super) fn ports(scene: &Scene, described: &[Described<'_>]) -> Vec<Problem> {
    let of = |role| described.iter().find(|(component, _)| component.role == role);
    let message = match (of(Role::Fluid), of(Role::Grains)) {
        (None, _) => "is that of the fluid at a face, but the run has no fluid".to_string(),
        (Some((component, fluid)), _) if !fluid.ports => format!(
            "is that of the fluid at a face, which {}, the run's {}, does not tell",
            fluid.program, component.name
        ),
        (_, Some((component, grains))) if !grains.ports => format!(
            "is that of the fluid at a face, which {}, the run's {}, does not take",
            grains.program, component.name
        ),
        _ => return Vec::new(),
    };
    let inlets = scene.inlets.iter().enumerate();
    let of_face = inlets.filter(|(_, inlet)| matches!(inlet.velocity, InletVelocity::Face { .. }));
    let problem = |(i, _)| {
        Problem::new(format!("scene.inlets[{i}].velocity"), message.clone())
            .help("give the velocity as a vector")
    };
    of_face.map(problem).collect()
}

/// Profiles need grains that measure them.
pub(super) fn profiles(scene: &Scene, described: &[Described<'_>]) -> Vec<Problem> {
    let is_known = |name: &str| {
        described.iter().any(|(_, d)| d.profiles.iter().any(|profile| profile.name == name))
    };
    let grains = described.iter().find(|(component, _)| component.role == Role::Grains);
    let (message, help) = match grains {
        Some((component, grains)) => (
            format!("{}, the run's {}, measures no profiles", grains.program, component.name),
            "leave out the profiles, or take another program for the grains, as \"grains-dem\"",
        ),
        None => (
            "nobody measures this profile: there is no component with the role grains".into(),
            "add grains = \"grains-dem\" to [components]",
        ),
    };
    let unknown = scene.profiles.iter().enumerate().filter(|(_, profile)| !is_known(&profile.name));
    unknown
        .map(|(i, _)| Problem::new(format!("scene.profiles[{i}]"), message.clone()).help(help))
        .collect()
}

fn suggest(problem: Problem, word: &str, known: &[&str], what: &str) -> Problem {
    match nearest(word, known) {
        Some(near) => problem.help(format!("did you mean \"{near}\"?")),
        None if known.is_empty() => problem.help(format!("there are no {what}")),
        None => problem.help(format!("{what}: {}", known.join(", "))),
    }
}
