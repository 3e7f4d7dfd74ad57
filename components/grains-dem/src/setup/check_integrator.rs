//! Checks that bodies are of the kinds that an integrator moves.

use crate::math::parameters::{Integrator, Parameters};
use tremie_messages::{
    Problem,
    scene::{Motion, Scene},
};

/// All kinds of bodies go with Verlet's, spheres and cylinders with the others.
pub(crate) fn check(scene: &Scene, parameters: &Parameters, problems: &mut Vec<Problem>) {
    let integrator = parameters.integrator;
    if integrator == Integrator::Verlet {
        return;
    }
    let slider = scene.parts.iter().find(|part| matches!(part.motion, Motion::Slider(_)));
    let clump = scene.bodies.iter().find(|set| set.clump.is_some());
    let others = [
        slider.map(|part| format!("the part \"{}\" is a slider", part.name)),
        (!scene.surfaces.is_empty()).then(|| "there is a surface that deforms".into()),
        clump.map(|set| format!("the bodies \"{}\" are clumps", set.name)),
        scene.has_polyhedra().then(|| "there are polyhedra".into()),
    ];
    for other in others.into_iter().flatten() {
        let message = format!("is \"{}\", but {other}", integrator.name());
        let help = "it moves spheres and cylinders among parts that stand still or move as given; leave it unset";
        problems.push(Problem::of_parameter("integrator", message).help(help));
    }
}
