//! Demands of a scene that this fluid cannot meet.

use tremie_fluid_kit::cells::grid::face_name;
use tremie_fluid_kit::checks::material_check::check_material;
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Face, Motion, PartBoundary, Scene};

/// Checks of the scene that concern a fluid.
pub fn check_scene(scene: &Scene, problems: &mut Vec<Problem>) {
    if check_material(scene, problems).is_none() {
        return;
    }
    check_faces(&scene.domain, problems);
    for (index, part) in scene.parts.iter().enumerate() {
        let key = format!("scene.parts[{index}]");
        if part.boundary != PartBoundary::Wall {
            let found = format!(
                "{} lets fluid through, but the particle fluid knows walls only",
                part.name
            );
            problems.push(Problem::new(format!("{key}.boundary"), found).help("make it a wall"));
        }
        if part.motion != Motion::Fixed && part.cavity {
            let found = format!(
                "{} moves; the particle fluid knows cavities only of parts that stand still",
                part.name
            );
            let problem = Problem::new(format!("{key}.cavity"), found);
            problems.push(problem.help("fix the part, or make it a solid"));
        }
    }
    for (index, set) in scene.bodies.iter().enumerate() {
        if let Some(clump) = &set.clump {
            let found = format!(
                "the bodies belong to the clump {clump}, which the particle fluid would take for bodies of their own"
            );
            let problem = Problem::new(format!("scene.bodies[{index}].clump"), found);
            problems.push(problem.help("take single bodies, or fluid = \"fluid-lbm\""));
        }
    }
    if !scene.gaps.is_empty() {
        let found = "the particle fluid has no model of gaps that open and close";
        problems.push(Problem::new("scene.gaps[0]", found).help("leave scene.gaps out"));
    }
}

/// Faces that are there: walls and mirrors.
fn check_faces(domain: &Domain, problems: &mut Vec<Problem>) {
    for axis in 0..3 {
        for side in 0..2 {
            let found = match &domain.faces[axis][side] {
                Face::Wall { .. } | Face::Symmetry => continue,
                Face::Periodic if side == 1 => continue,
                Face::Periodic => "is periodic",
                Face::Velocity(_) => "has a velocity",
                Face::Pressure { .. } => "has a pressure",
                Face::Reservoir(_) => "has a reservoir",
            };
            let name = ["x", "y", "z"][axis];
            let message = format!(
                "the face {} {found}, but the particle fluid knows walls and symmetry planes only",
                face_name(axis, side)
            );
            let problem = Problem::new(format!("scene.domain.{name}"), message);
            problems.push(problem.help("make it a wall, or take fluid = \"fluid-lbm\""));
        }
    }
}
