//! Everything that can be wrong with a scene, as the grains see it.

use crate::Vec3;
use crate::bodies::body_arrays::BoundingSphere;
use crate::contact::{material_laws, plane_walls};
use crate::math::numbers::is_positive;
use crate::math::parameters::{Lubrication, Parameters};
use crate::math::periodic::PeriodicBox;
use crate::packing::random_packing::{self};
use crate::setup::material_pairs::BodyStatistics;
use crate::setup::{
    check_clumps, check_drag_bands, check_integrator, check_law, check_packing, check_polyhedra,
    check_ports, check_profiles, check_slider,
};
use crate::solver::overlaps::TOUCHING;
use crate::solver::placement;
use tremie_messages::{
    Problem,
    scene::{BodySet, Domain, Motion, Placement, Plane, Scene, Sphere, TimedMotion},
    units::Length,
};

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

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
    domain(&scene.domain, &mut problems);
    let domain_is_valid = problems.len() == before;
    for (i, p) in scene.planes.iter().enumerate() {
        plane(&format!("scene.planes[{i}]"), p, &scene.domain, &mut problems);
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
                    listed(&key, set, sphere, &mut problems);
                    if domain_is_valid && planes_are_valid {
                        inside(&key, set, sphere, scene, &mut problems);
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
        Motion::Timed(timed) => return self::timed(key, timed, problems),
        Motion::Prescribed(points) => points,
    };
    for (i, point) in points.iter().enumerate() {
        let finite = all_finite(&point.velocity) && all_finite(&point.angular_velocity);
        if !(finite && point.time.is_finite()) {
            let problem = Problem::new(format!("{key}.prescribed[{i}]"), "is not finite");
            problems.push(problem);
        }
        if i > 0 && point.time <= points[i - 1].time {
            let (before, found) = (points[i - 1].time, point.time);
            let message = format!("is {found} s, not later than the point before, {before} s");
            problems.push(Problem::new(format!("{key}.prescribed[{i}].time"), message));
        }
    }
}

fn timed(key: &str, timed: &TimedMotion, problems: &mut Vec<Problem>) {
    if !(all_finite(&timed.velocity) && all_finite(&timed.angular_velocity)) {
        problems.push(Problem::new(format!("{key}.timed"), "is not finite"));
    } else if let Some(flaw) = timed.course.flaw() {
        problems.push(Problem::new(format!("{key}.timed.course"), flaw));
    }
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

/// Fewest steps in a collision that still resolve it (Goetsch, PhD thesis, 2015, sec. 3.3).
pub(crate) const MIN_STEPS_PER_CONTACT: f64 = 7.0;

fn domain(domain: &Domain, problems: &mut Vec<Problem>) {
    let extent = domain.size();
    for axis in 0..3 {
        let name = AXES[axis];
        if !is_positive(extent[axis]) || !domain.min[axis].is_finite() {
            let message = format!("has no extent in {name}: its size there is {} m", extent[axis]);
            problems.push(Problem::new("scene.domain", message));
        }
    }
}

fn plane(key: &str, plane: &Plane, domain: &Domain, problems: &mut Vec<Problem>) {
    let square = Vec3::from(plane.normal).norm_squared();
    if !all_finite(&plane.point) {
        problems.push(Problem::new(format!("{key}.point"), "is not finite"));
    }
    if !is_positive(square) {
        problems.push(Problem::new(format!("{key}.normal"), "has no direction"));
    }
    for axis in 0..3 {
        if domain.is_periodic(axis) && plane.normal[axis] != 0.0 {
            let name = AXES[axis];
            let message =
                format!("has a component along {name}, which wraps around: the plane would not");
            let help =
                format!("make {name} of the normal 0, or the domain's faces in {name} walls");
            problems.push(Problem::new(format!("{key}.normal"), message).help(help));
        }
    }
}

fn listed(key: &str, set: &BodySet, sphere: &Sphere, problems: &mut Vec<Problem>) {
    if !is_positive(sphere.diameter) {
        problems.push(not_positive(format!("{key}.diameter"), sphere.diameter));
    }
    for (name, vector) in [
        ("position", &sphere.position),
        ("velocity", &sphere.velocity),
        ("angular_velocity", &sphere.angular_velocity),
    ] {
        if !all_finite(vector) {
            problems.push(Problem::new(format!("{key}.{name}"), "is not finite"));
        }
    }
    let moves = sphere.velocity != [0.0; 3] || sphere.angular_velocity != [0.0; 3];
    if set.motion == Motion::Fixed && moves {
        let help = "use the motion \"prescribed\" to keep a velocity";
        let problem = Problem::new(format!("{key}.velocity"), "is that of a fixed body");
        problems.push(problem.help(help));
    }
}

/// The centre must lie in the domain; a free sphere as a whole on the right side of walls.
fn inside(key: &str, set: &BodySet, sphere: &Sphere, scene: &Scene, problems: &mut Vec<Problem>) {
    let key = format!("{key}.position");
    let ball = BoundingSphere { x: sphere.position.into(), radius: 0.5 * sphere.diameter };
    if !PeriodicBox::new(&scene.domain).contains(ball.x) {
        problems.push(Problem::new(key, "lies outside the domain"));
        return;
    }
    if set.motion != Motion::Free {
        return;
    }
    let surfaces = material_laws::surfaces(scene);
    for (index, wall) in plane_walls::of_scene(scene).iter().enumerate() {
        let overlap = wall.overlap(&ball);
        if overlap > TOUCHING * ball.radius {
            let name = &surfaces[index].name;
            let message = format!("puts the sphere {overlap:.3e} m into {name}");
            problems.push(Problem::new(key.as_str(), message));
        }
    }
}

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

pub(crate) fn all_finite(v: &[f64; 3]) -> bool {
    v.iter().all(|x| x.is_finite())
}

pub(crate) fn not_positive(key: String, value: f64) -> Problem {
    Problem::new(key, format!("is {value}, expected a positive number"))
}
