//! Checks of inlets and outlets.

use crate::Vec3;
use crate::bodies::placed_parts::PlacedPart;
use crate::math::parameters::Parameters;
use crate::solver::{placement, ports};
use core::f64::consts::PI;
use tremie_grains_kit::checks::check_packing;
use tremie_grains_kit::checks::numbers::{AXES, not_positive};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_grains_kit::packing::random_packing::{self, Feeding};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls;
use tremie_messages::{
    Problem,
    scene::{Inlet, InletVelocity, Motion, Outlet, Placement, Scene},
};

/// Solid fraction at which spheres that come one by one find no place any more.
const JAMMED: f64 = 0.38;

/// Checks inlets, outlets and the capacity, but not what parts leave free of a region.
pub(crate) fn ports(scene: &Scene, parameters: &Parameters, problems: &mut Vec<Problem>) {
    for (i, one) in scene.outlets.iter().enumerate() {
        outlet(&format!("scene.outlets[{i}]"), one, scene, problems);
    }
    for (i, one) in scene.inlets.iter().enumerate() {
        inlet(&format!("scene.inlets[{i}]"), one, scene, problems);
    }
    if !problems.is_empty() {
        return;
    }
    let start: usize = scene.bodies.iter().map(|set| random_packing::diameters_of(set).len()).sum();
    let given = parameters.capacity.filter(|_| !scene.inlets.is_empty());
    if let Some(capacity) = given.filter(|capacity| *capacity < start as u64) {
        let message = format!("is {capacity}, less than the {start} spheres at the start");
        problems.push(Problem::of_parameter("capacity", message));
    }
    all_at_once(scene, problems);
}

/// Checks that the regions of inlets have room outside of parts for a sphere.
pub(crate) fn room(scene: &Scene, parts: &[PlacedPart]) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    for (i, inlet) in scene.inlets.iter().enumerate() {
        let around = random_packing::PackingSurroundings {
            parts,
            bounds: PeriodicBox::new(&scene.domain),
            planes: plane_walls::of_scene(scene),
            balls: Vec::new(),
        };
        let diameter = inlet.diameters.extremes()[1];
        let free = Feeding::new(&ports::region(inlet), &around, 0.5 * diameter).free_volume();
        if free < PI / 6.0 * diameter * diameter * diameter {
            let message = format!(
                "lies in solid: {free:.3e} m3 of the region are outside of parts, less than a sphere of \
                 {diameter:.3e} m"
            );
            let help = "move the region to where grains can be";
            problems.push(Problem::new(format!("scene.inlets[{i}].min"), message).help(help));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

fn inlet(key: &str, inlet: &Inlet, scene: &Scene, problems: &mut Vec<Problem>) {
    let before = problems.len();
    match scene.bodies.iter().find(|set| set.name == inlet.bodies) {
        None => {
            let message = format!("is \"{}\", but no set of bodies has this name", inlet.bodies);
            problems.push(Problem::new(format!("{key}.bodies"), message));
        }
        Some(set) if set.motion != Motion::Free => {
            let message = format!("is \"{}\", whose bodies are not free", inlet.bodies);
            problems.push(Problem::new(format!("{key}.bodies"), message));
        }
        Some(_) => {}
    }
    check_packing::packing(key, &ports::region(inlet), 1.0, &scene.domain, problems);
    if inlet.fraction > JAMMED {
        let message = format!(
            "is {}, but spheres that come one by one find no place beyond {JAMMED}",
            inlet.fraction
        );
        let help = "lower it, or begin with a packing and let it flow";
        problems.push(Problem::new(format!("{key}.fraction"), message).help(help));
    }
    for (name, time) in [("every", inlet.every), ("until", inlet.until)] {
        if let Some(time) = time.filter(|time| !is_positive(*time)) {
            problems.push(not_positive(format!("{key}.{name}"), time));
        }
    }
    if inlet.tries == 0 {
        problems.push(Problem::new(format!("{key}.tries"), "is 0, expected 1 or more"));
    }
    velocity(key, inlet, scene, problems);
    if problems.len() > before {
        return;
    }
    let [min, max] = [Vec3::from(inlet.min), Vec3::from(inlet.max)];
    let (middle, outlets) = (0.5 * (min + max), scene.outlets.iter());
    if let Some(outlet) = outlets.clone().find(|outlet| outlet.holds(middle.into())) {
        let message =
            format!("lies in the outlet \"{}\": what comes there goes at once", outlet.name);
        problems.push(Problem::new(format!("{key}.min"), message));
    }
}

fn velocity(key: &str, inlet: &Inlet, scene: &Scene, problems: &mut Vec<Problem>) {
    let key = format!("{key}.velocity");
    match inlet.velocity {
        InletVelocity::Given(velocity) if velocity.iter().any(|v| !v.is_finite()) => {
            problems.push(Problem::new(key, "is not finite"));
        }
        InletVelocity::Given(_) => {}
        InletVelocity::Face { axis, side } => {
            let face = scene.domain.faces.get(axis).and_then(|faces| faces.get(side));
            if !face.is_some_and(tremie_messages::scene::Face::is_open) {
                let message = "is that at a face which is not open: no fluid comes through it";
                problems.push(Problem::new(key, message));
            }
        }
    }
}

fn outlet(key: &str, outlet: &Outlet, scene: &Scene, problems: &mut Vec<Problem>) {
    let (domain, Outlet { axis, at, side, .. }) = (&scene.domain, outlet);
    if *axis > 2 || *side > 1 {
        problems.push(Problem::new(format!("{key}.beyond"), "has no such axis or side"));
        return;
    }
    let (axis, side) = (*axis, *side);
    if !(domain.min[axis]..=domain.max[axis]).contains(at) {
        let message = format!("is at {at} m, outside the domain in {}", AXES[axis]);
        problems.push(Problem::new(format!("{key}.beyond"), message));
        return;
    }
    if domain.is_periodic(axis) || scene.is_way_out(axis, side) {
        return;
    }
    let face = [domain.min, domain.max][side][axis];
    let diameters = scene.bodies.iter().flat_map(random_packing::diameters_of);
    let fed = scene.inlets.iter().map(|inlet| inlet.diameters.extremes()[1]);
    let radius = 0.5 * diameters.chain(fed).fold(0.0, f64::max);
    if (face - at).abs() < radius {
        let message = format!(
            "is {:.3e} m from the domain's face in {}, a wall that spheres of {:.3e} m touch before \
             they go",
            (face - at).abs(),
            AXES[axis],
            2.0 * radius
        );
        let help = "move it inwards by a radius, or make the face one that is open to the fluid";
        problems.push(Problem::new(format!("{key}.beyond"), message).help(help));
    }
}

/// An outlet in which all of the spheres at the start lie is a slip.
fn all_at_once(scene: &Scene, problems: &mut Vec<Problem>) {
    let listed = placement::listed(scene);
    let corners = scene.bodies.iter().filter_map(|set| match &set.placement {
        // Polyhedra are refused beside outlets.
        Placement::Listed(_) | Placement::Polyhedra(_) => None,
        Placement::Packed(packing) => Some((packing.min, packing.max)),
    });
    for (i, outlet) in scene.outlets.iter().enumerate() {
        let packed = |(min, max): ([f64; 3], [f64; 3])| outlet.holds(min) && outlet.holds(max);
        let spheres = listed.iter().all(|sphere| outlet.holds(sphere.ball.x.into()));
        let any = !listed.is_empty() || corners.clone().next().is_some();
        if any && spheres && corners.clone().all(packed) {
            let message = "holds all spheres of the start: they would go at once";
            let key = format!("scene.outlets[{i}].beyond");
            problems.push(Problem::new(key, message).help("is its side the one that was meant?"));
        }
    }
}
