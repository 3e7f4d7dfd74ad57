//! Everything that can be wrong with a scene, as the grains see it.

use crate::contact::material_laws;
use crate::math::parameters::{Lubrication, Parameters};
use crate::setup::material_pairs::BodyStatistics;
use crate::setup::{
    check_clumps, check_drag_bands, check_integrator, check_law, check_polyhedra, check_ports,
    check_profiles, check_slider,
};
use crate::solver::placement;
use tremie_grains_kit::checks::numbers::{AXES, all_finite, not_positive};
use tremie_grains_kit::checks::{check_packing, check_scene};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_grains_kit::packing::random_packing::{self};
use tremie_messages::{
    Problem,
    scene::{Motion, Placement, Scene},
    units::Length,
};

/// Checks numbers and geometry, but not overlaps between bodies.
pub(crate) fn scene(scene: &Scene, parameters: &Parameters) -> Vec<Problem> {
    let mut problems = own_parameters(parameters);
    if !all_finite(&scene.gravity) {
        problems.push(Problem::new("scene.gravity", "is not finite"));
    }
    if parameters.lubrication.is_some() && scene.fluid.is_none() {
        let message = "is set, but the scene has no fluid, whose viscosity it needs";
        let help = "give the scene a fluid, or leave lubrication unset";
        problems.push(Problem::of_parameter("lubrication", message).help(help));
    }
    let before = problems.len();
    check_scene::domain(&scene.domain, &mut problems);
    let domain_is_valid = problems.len() == before;
    for (i, p) in scene.planes.iter().enumerate() {
        check_scene::plane(&format!("scene.planes[{i}]"), p, &scene.domain, &mut problems);
    }
    let planes_are_valid = problems.len() == before;
    for (i, part) in scene.parts.iter().enumerate() {
        motion(&format!("scene.parts[{i}].motion"), &part.motion, &mut problems);
    }
    for (i, set) in scene.bodies.iter().enumerate() {
        let key = format!("scene.bodies[{i}]");
        motion(&format!("{key}.motion"), &set.motion, &mut problems);
        if matches!(set.motion, Motion::Slider(_)) {
            let message = "is that of a slider, but spheres do not slide on an axis";
            let help = "make it a part with the shape of a sphere";
            problems.push(Problem::new(format!("{key}.motion"), message).help(help));
        }
        if !is_positive(set.density) {
            problems.push(not_positive(format!("{key}.density"), set.density));
        }
        match &set.placement {
            Placement::Listed(list) => {
                for (k, sphere) in list.iter().enumerate() {
                    let key = format!("{key}.placement.listed[{k}]");
                    check_scene::listed(&key, set, sphere, &mut problems);
                    if domain_is_valid && planes_are_valid {
                        check_scene::inside(&key, set, sphere, scene, &mut problems);
                    }
                }
            }
            Placement::Packed(packed) => {
                check_packing::packing(
                    &format!("{key}.placement.packed"),
                    packed,
                    1.0,
                    &scene.domain,
                    &mut problems,
                );
            }
            Placement::Polyhedra(own) => {
                check_polyhedra::set(&key, set, own, scene, &mut problems);
            }
        }
    }
    check_polyhedra::shapes(scene, parameters, &mut problems);
    check_clumps::clumps(scene, &mut problems);
    check_law::laws(scene, &mut problems);
    check_integrator::check(scene, parameters, &mut problems);
    check_drag_bands::drag_bands(scene, &mut problems);
    check_profiles::profiles(scene, &mut problems);
    if problems.is_empty() {
        // These checks rely on a scene that is valid so far.
        check_ports::ports(scene, parameters, &mut problems);
    }
    if problems.is_empty() {
        whole(scene, parameters, &mut problems);
    }
    problems
}

fn motion(key: &str, motion: &Motion, problems: &mut Vec<Problem>) {
    let points = match motion {
        Motion::Free | Motion::Fixed => return,
        Motion::Slider(slider) => return check_slider::slider(key, slider, problems),
        Motion::Timed(timed) => return check_scene::timed(key, timed, problems),
        Motion::Prescribed(points) => points,
    };
    check_scene::points(key, points, problems);
}

fn own_parameters(parameters: &Parameters) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(step) = parameters.time_step
        && !is_positive(step.0)
    {
        problems.push(Problem::of_parameter(
            "time_step",
            format!("is {} s, expected a positive time", step.0),
        ));
    }
    let steps = parameters.steps_per_contact;
    if !(steps.is_finite() && steps >= MIN_STEPS_PER_CONTACT) {
        let message = format!("is {steps}, expected at least {MIN_STEPS_PER_CONTACT}");
        let help = "15 give a few per cent of error in flows, 50 are for validation";
        problems.push(Problem::of_parameter("steps_per_contact", message).help(help));
    }
    if let Some(speed) = parameters.expected_speed
        && !is_positive(speed.0)
    {
        let message = format!("is {} m/s, expected a positive speed", speed.0);
        problems.push(Problem::of_parameter("expected_speed", message));
    }
    if let Some(Lubrication { cutoff: Length(cutoff), roughness: Length(roughness) }) =
        parameters.lubrication
        && !(roughness > 0.0 && roughness < cutoff && cutoff.is_finite())
    {
        let message =
            format!("is {roughness} m, expected more than 0 and less than the cut-off, {cutoff} m");
        problems.push(Problem::of_parameter("lubrication.roughness", message));
    }
    let skin = parameters.skin_fraction();
    if !(skin > 0.0 && skin <= 1.0) {
        let message = format!("is {skin}, expected a fraction of the largest diameter in (0, 1]");
        problems.push(Problem::of_parameter("skin", message));
    }
    problems
}

/// Fewest steps in a collision that still resolve it (Goetsch, thesis, 2015, sec. 3.3).
pub(crate) const MIN_STEPS_PER_CONTACT: f64 = 7.0;

/// Checks the scene as a whole, once its parts are valid.
fn whole(scene: &Scene, parameters: &Parameters, problems: &mut Vec<Problem>) {
    // Bodies that stand still or move as prescribed meet only what is free.
    let [mut free, mut held] = [0.0f64; 2];
    for (i, set) in scene.bodies.iter().enumerate() {
        let diameters = random_packing::diameters_of(set);
        let fed = scene.inlets.iter().any(|inlet| inlet.bodies == set.name);
        if diameters.is_empty() && !fed {
            let message = "holds no body";
            let help = "raise the fraction or enlarge the region: half a sphere is too little";
            problems.push(Problem::new(format!("scene.bodies[{i}].placement"), message).help(help));
        }
        let around = placement::around(scene, set);
        let largest = if set.motion == Motion::Free { &mut free } else { &mut held };
        *largest = diameters.iter().fold(*largest, |a, &d| a.max(d * around));
    }
    free = scene.inlets.iter().fold(free, |d, inlet| d.max(inlet.diameters.extremes()[1]));
    check_clumps::wholes(scene, problems);
    problems.extend(BodyStatistics::of(scene).problems());
    let film = parameters.lubrication.map_or(0.0, |lubrication| lubrication.cutoff.0);
    let reach = film.max(material_laws::longest_neck(scene, free.max(held)));
    let skin = parameters.skin_fraction() * free.max(held);
    let needed = if free > 0.0 { free + free.max(held) + 2.0 * (skin + reach) } else { 0.0 };
    for axis in 0..3 {
        let size = scene.domain.size()[axis];
        if scene.domain.is_periodic(axis) && size < needed {
            let message = format!(
                "is {size} m long in {}, where it wraps around: a body would meet another \
                 through both faces",
                AXES[axis]
            );
            let help = format!("make it at least {needed:.6e} m, or its faces walls");
            problems.push(Problem::new("scene.domain", message).help(help));
        }
    }
}
