//! Checks of polyhedra.

use crate::Vec3;
use crate::contact::springs::RegisteredSpring;
use crate::math::parameters::Parameters;
use crate::polyhedra::Shape;
use tremie_geometry::Convex;
use tremie_grains_kit::checks::check_packing;
use tremie_grains_kit::checks::numbers::{AXES, all_finite, not_positive};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::{
    Problem,
    scene::{
        BodySet, Motion, Packing, Placement, Polyhedra as Set, Polyhedron, PolyhedronPlacement,
        Scene, Shape as SceneShape,
    },
};

/// Solid fraction that the spheres around packed polyhedra can reach: spheres at random do not
/// more.
const DENSEST: f64 = 0.6;

/// Checks the shapes of a scene, and its other settings for polyhedra.
pub(crate) fn shapes(scene: &Scene, parameters: &Parameters, problems: &mut Vec<Problem>) {
    for (i, shape) in scene.shapes.iter().enumerate() {
        if let Err(error) = Shape::of(shape) {
            let message = format!("makes no shape of polyhedra: {error}");
            problems.push(Problem::new(format!("scene.shapes[{i}].vertices"), message));
        }
    }
    if !scene.has_polyhedra() {
        return;
    }
    let ports = [("inlets", scene.inlets.len()), ("outlets", scene.outlets.len())];
    for (key, _) in ports.iter().filter(|(_, count)| *count > 0) {
        let message = "is there, but polyhedra do not come and go yet";
        let help = "take spheres, or a run without inlets and outlets";
        problems.push(Problem::new(format!("scene.{key}[0]"), message).help(help));
    }
    if !scene.surfaces.is_empty() {
        let message = "is there, but polyhedra do not feel surfaces that deform yet";
        let help = "take spheres, or leave out the surface and the rubber";
        problems.push(Problem::new("scene.surfaces[0]", message).help(help));
    }
    if parameters.lubrication.is_some() {
        let message = "is set, but it is a law for spheres, and there are polyhedra";
        problems.push(Problem::of_parameter("lubrication", message).help("leave it unset"));
    }
    for (i, pair) in scene.contacts.iter().enumerate() {
        let met = |set: &&BodySet| {
            matches!(set.placement, Placement::Polyhedra(_)) && pair.between.contains(&set.material)
        };
        let spring = RegisteredSpring::of(&pair.law.spring);
        if let (Some(set), None) = (scene.bodies.iter().find(met), spring.law().as_linear()) {
            let (name, set) = (spring.law().name(), &set.name);
            let message = format!("is {name}, which has no form for polyhedra, as \"{set}\" are");
            let help = "give a normal and a tangential stiffness";
            problems
                .push(Problem::new(format!("scene.contacts[{i}].law.spring"), message).help(help));
        }
    }
}

/// A set of polyhedra, but not where they are.
pub(crate) fn set(key: &str, set: &BodySet, own: &Set, scene: &Scene, problems: &mut Vec<Problem>) {
    let shape = scene.shapes.iter().find(|shape| shape.name == own.shape);
    let Some(shape) = shape else {
        let message = format!("is \"{}\", expected the name of one of scene.shapes", own.shape);
        problems.push(Problem::new(format!("{key}.placement.polyhedra.shape"), message));
        return;
    };
    let key = format!("{key}.placement.polyhedra.placement");
    if let Some(across) = scene.domain.across {
        return plane_set(&key, set, own, (shape, across), scene, problems);
    }
    match &own.placement {
        PolyhedronPlacement::Listed(list) => {
            for (k, body) in list.iter().enumerate() {
                listed(&format!("{key}.listed[{k}]"), set, body, problems);
            }
        }
        PolyhedronPlacement::Packed(packing) => {
            let key = format!("{key}.packed");
            let Ok(shape) = Shape::of(shape) else { return };
            let around = 2.0 * shape.circumradius;
            let most = DENSEST / (around * around * around);
            if packing.fraction > most {
                let message = format!(
                    "is {}, expected at most {most:.3}: packed polyhedra lie in spheres that do not overlap",
                    packing.fraction
                );
                let help = "lower it, and let them settle";
                problems.push(Problem::new(format!("{key}.fraction"), message).help(help));
            }
            let scaled = Packing { fraction: packing.fraction.min(most), ..packing.clone() };
            check_packing::packing(&key, &scaled, around, &scene.domain, problems);
        }
    }
}

/// A set of polyhedra in a plane scene: prisms along the axis across it, as long as it is deep,
/// that turn about this axis alone.
fn plane_set(
    key: &str,
    set: &BodySet,
    own: &Set,
    (shape, across): (&SceneShape, usize),
    scene: &Scene,
    problems: &mut Vec<Problem>,
) {
    let PolyhedronPlacement::Listed(list) = &own.placement else {
        let message = "packs polyhedra, but the scene is plane";
        problems.push(Problem::new(format!("{key}.packed"), message).help("list them as prisms"));
        return;
    };
    let (domain, name) = (&scene.domain, AXES[across]);
    let middle = 0.5 * (domain.min[across] + domain.max[across]);
    let (depth, Ok(convex)) = (domain.size()[across], Convex::hull(&shape.vertices)) else {
        return;
    };
    let convex = convex.unit();
    let is_prism = |n: f64| n.abs() < PRISM || n.abs() > 1.0 - PRISM;
    if !convex.faces().iter().all(|face| is_prism(face.normal[across])) {
        let message = format!(
            "has the shape \"{}\", which is no prism along {name}, across the plane scene",
            own.shape
        );
        problems.push(Problem::new(key, message).help("give the shape an outline"));
        return;
    }
    let mut axis = Vec3::zeros();
    axis[across] = 1.0;
    for (k, body) in list.iter().enumerate() {
        let key = format!("{key}.listed[{k}]");
        listed(&key, set, body, problems);
        let length = convex.width_along(axis) * body.diameter;
        if ((length - depth) / depth).abs() > PRISM {
            let message = format!("is {length} m long, but the plane scene is {depth} m deep");
            problems.push(Problem::new(format!("{key}.diameter"), message));
        }
        if (body.position[across] - middle).abs() > PRISM * depth {
            let found = body.position[across];
            let message = format!("is {found} m along {name}, expected the middle, {middle} m");
            problems.push(Problem::new(format!("{key}.position"), message));
        }
        let turns = |q: &[f64]| (0..3).any(|a| a != across && q[a].abs() > PRISM);
        if turns(&body.orientation) || turns(&body.angular_velocity) {
            let message = format!("turns about another axis than {name}, out of the plane");
            problems.push(Problem::new(format!("{key}.orientation"), message));
        }
    }
}

/// Largest difference from a prism as long as a plane scene is deep, in terms of its edges.
const PRISM: f64 = 1e-6;

fn listed(key: &str, set: &BodySet, body: &Polyhedron, problems: &mut Vec<Problem>) {
    if !is_positive(body.diameter) {
        problems.push(not_positive(format!("{key}.diameter"), body.diameter));
    }
    for (name, vector) in [
        ("position", &body.position),
        ("velocity", &body.velocity),
        ("angular_velocity", &body.angular_velocity),
    ] {
        if !all_finite(vector) {
            problems.push(Problem::new(format!("{key}.{name}"), "is not finite"));
        }
    }
    let square: f64 = body.orientation.iter().map(|c| c * c).sum();
    if (square - 1.0).abs().is_nan() || (square - 1.0).abs() > 1e-6 {
        let message = format!("is {:?}, expected a unit quaternion", body.orientation);
        problems.push(Problem::new(format!("{key}.orientation"), message));
    }
    if set.motion == Motion::Fixed && (body.velocity, body.angular_velocity) != ([0.0; 3], [0.0; 3])
    {
        let help = "use the motion \"prescribed\" to keep a velocity";
        let problem = Problem::new(format!("{key}.velocity"), "is that of a fixed body");
        problems.push(problem.help(help));
    }
}
