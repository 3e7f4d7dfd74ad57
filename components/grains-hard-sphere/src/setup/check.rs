//! Everything that can be wrong with a scene, as hard spheres see it.

use crate::setup::parameters::{Detection, Parameters};
use crate::setup::refusals::refusals;
use tremie_grains_kit::checks::numbers::{AXES, all_finite, not_positive};
use tremie_grains_kit::checks::{check_packing, check_scene};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_grains_kit::packing::random_packing;
use tremie_grains_kit::space::plane_walls;
use tremie_messages::Problem;
use tremie_messages::scene::{Motion, Placement, Scene};

/// Checks numbers and geometry, but not overlaps between bodies.
pub fn scene(scene: &Scene, parameters: &Parameters) -> Vec<Problem> {
    let mut problems = own_parameters(parameters, scene);
    problems.extend(refusals(scene));
    if !all_finite(&scene.gravity) {
        problems.push(Problem::new("scene.gravity", "is not finite"));
    }
    let before = problems.len();
    check_scene::domain(&scene.domain, &mut problems);
    for (i, plane) in scene.planes.iter().enumerate() {
        check_scene::plane(&format!("scene.planes[{i}]"), plane, &scene.domain, &mut problems);
    }
    let box_is_valid = problems.len() == before;
    for (i, part) in scene.parts.iter().enumerate() {
        motion(&format!("scene.parts[{i}].motion"), &part.motion, &mut problems);
    }
    for (i, set) in scene.bodies.iter().enumerate() {
        let key = format!("scene.bodies[{i}]");
        motion(&format!("{key}.motion"), &set.motion, &mut problems);
        if !is_positive(set.density) {
            problems.push(not_positive(format!("{key}.density"), set.density));
        }
        match &set.placement {
            Placement::Listed(list) => {
                for (k, sphere) in list.iter().enumerate() {
                    let key = format!("{key}.placement.listed[{k}]");
                    check_scene::listed(&key, set, sphere, &mut problems);
                    if box_is_valid {
                        check_scene::inside(&key, set, sphere, scene, &mut problems);
                    }
                }
            }
            Placement::Packed(packed) => {
                let key = format!("{key}.placement.packed");
                check_packing::packing(&key, packed, 1.0, &scene.domain, &mut problems);
            }
            // Refused as a whole.
            Placement::Polyhedra(_) => {}
        }
    }
    if problems.is_empty() {
        whole(scene, &mut problems);
    }
    problems
}

fn motion(key: &str, motion: &Motion, problems: &mut Vec<Problem>) {
    match motion {
        Motion::Free | Motion::Fixed | Motion::Slider(_) => {}
        Motion::Prescribed(points) => check_scene::points(key, points, problems),
        Motion::Timed(timed) => check_scene::timed(key, timed, problems),
    }
}

fn own_parameters(parameters: &Parameters, scene: &Scene) -> Vec<Problem> {
    let mut problems = Vec::new();
    let numbers = [
        ("time_step", parameters.time_step.map(|t| t.0), "s", false),
        ("expected_speed", parameters.expected_speed.map(|v| v.0), "m/s", false),
        ("contact_time", parameters.contact_time.map(|t| t.0), "s", true),
        ("elastic_speed", parameters.elastic_speed.map(|v| v.0), "m/s", true),
    ];
    for (name, value, unit, may_be_zero) in numbers {
        let Some(value) = value else { continue };
        if !(is_positive(value) || (may_be_zero && value == 0.0)) {
            let expected = if may_be_zero { "0 or more" } else { "more than 0" };
            let message = format!("is {value} {unit}, expected {expected}");
            problems.push(Problem::of_parameter(name, message));
        }
    }
    let beta = parameters.tangential_restitution;
    if !(-1.0..=1.0).contains(&beta) {
        let message = format!("is {beta}, expected a number from -1 to 1");
        problems.push(Problem::of_parameter("tangential_restitution", message));
    }
    if parameters.most_collisions == 0 {
        let message = "is 0, expected at least 1";
        problems.push(Problem::of_parameter("most_collisions", message));
    }
    let has_weight = scene.gravity != [0.0; 3];
    let is_bare = parameters.elastic_speed.is_some_and(|v| v.0 == 0.0);
    if has_weight && is_bare && parameters.detection != Detection::Steps {
        let message =
            "is 0 m/s, but under gravity a body that comes to rest would collide for ever";
        let help = "leave it unset, or set detection = \"steps\"";
        problems.push(Problem::of_parameter("elastic_speed", message).help(help));
    }
    if parameters.detection == Detection::Events
        && let Some(what) = between_collisions(scene)
    {
        let message = format!("is \"events\", but {what} acts between collisions");
        let help = "leave it unset: from step to step such a scene can be had";
        problems.push(Problem::of_parameter("detection", message).help(help));
    }
    problems
}

/// What besides weight acts between collisions, in words.
pub fn between_collisions(scene: &Scene) -> Option<&'static str> {
    let moves = |motion: &Motion| matches!(motion, Motion::Prescribed(_) | Motion::Timed(_));
    if scene.fluid.is_some() {
        Some("the fluid")
    } else if scene.parts.iter().any(|part| moves(&part.motion)) {
        Some("a part that moves as prescribed")
    } else if scene.bodies.iter().any(|set| moves(&set.motion)) {
        Some("a body that moves as prescribed")
    } else if plane_walls::sliding(scene).iter().any(plane_walls::Sliding::changes) {
        Some("a face whose speed changes with time")
    } else {
        None
    }
}

/// Checks the scene as a whole, once its parts are valid.
fn whole(scene: &Scene, problems: &mut Vec<Problem>) {
    let mut largest = 0.0f64;
    for (i, set) in scene.bodies.iter().enumerate() {
        let diameters = random_packing::diameters_of(set);
        if diameters.is_empty() {
            let message = "holds no body";
            let help = "raise the fraction or enlarge the region: half a sphere is too little";
            problems.push(Problem::new(format!("scene.bodies[{i}].placement"), message).help(help));
        }
        largest = diameters.into_iter().fold(largest, f64::max);
    }
    let needed = CELLS * largest;
    for axis in (0..3).filter(|&axis| scene.domain.across != Some(axis)) {
        let size = scene.domain.size()[axis];
        if scene.domain.is_periodic(axis) && size < needed * (1.0 + 1e-6) {
            let message = format!(
                "is {size} m long in {}, where it wraps around, expected at least {CELLS} of the largest diameter",
                AXES[axis]
            );
            let help =
                format!("make it {:.6e} m or longer, or its faces walls", needed * (1.0 + 1e-6));
            problems.push(Problem::new("scene.domain", message).help(help));
        }
    }
    missing_laws(scene, problems);
}

/// Least number of cells, of a diameter and more, along an axis that wraps around.
const CELLS: f64 = 3.0;

/// Pairs of materials that may meet without a law.
fn missing_laws(scene: &Scene, problems: &mut Vec<Problem>) {
    let mut missing: Vec<[&str; 2]> = Vec::new();
    let mut need = |a, b, what: String| {
        let known = |pair: &[&str; 2]| *pair == [a, b] || *pair == [b, a];
        if scene.law(a, b).is_none() && !missing.iter().any(known) {
            missing.push([a, b]);
            let message = format!("has no law for \"{a}\" and \"{b}\", but {what}");
            problems.push(Problem::new("scene.contacts", message));
        }
    };
    let free = scene.bodies.iter().filter(|set| set.motion == Motion::Free);
    for set in free {
        for other in &scene.bodies {
            let what = format!("\"{}\" and \"{}\" may meet", set.name, other.name);
            need(&set.material, &other.material, what);
        }
        for (material, name) in plane_walls::materials(scene).zip(plane_walls::names(scene)) {
            need(&set.material, material, format!("\"{}\" may meet {name}", set.name));
        }
        for part in &scene.parts {
            let what = format!("\"{}\" may meet part \"{}\"", set.name, part.name);
            need(&set.material, &part.material, what);
        }
    }
}
