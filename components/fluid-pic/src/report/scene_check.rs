//! Demands of a scene that this fluid cannot meet.

use tremie_fluid_kit::cells::grid::face_name;
use tremie_fluid_kit::checks::material_check::check_material;
use tremie_messages::Problem;
use tremie_messages::scene::{Face, Motion, Outflow, PartBoundary, Scene};

/// Checks of the scene that concern a fluid.
pub fn check_scene(scene: &Scene, problems: &mut Vec<Problem>) {
    if check_material(scene, problems).is_none() {
        return;
    }
    check_faces(scene, problems);
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

/// Open faces, and the levels beyond them.
fn check_faces(scene: &Scene, problems: &mut Vec<Problem>) {
    let domain = &scene.domain;
    let has_surface = scene.fluid.as_ref().is_some_and(|fluid| !fluid.fill.is_empty());
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (side, end) in ["lower", "upper"].into_iter().enumerate() {
            let key = format!("scene.domain.{name}.{end}");
            let face = &domain.faces[axis][side];
            if let Some(problem) = check_face(face, axis, side, &key) {
                problems.push(problem);
                continue;
            }
            let level = domain.levels[axis][side];
            problems.extend(check_level(scene, face, axis, side, level, has_surface, &key));
        }
    }
}

/// Conditions that the fluid does not know.
fn check_face(face: &Face, axis: usize, side: usize, key: &str) -> Option<Problem> {
    let (found, help) = match face {
        Face::Reservoir(_) => (
            "has a reservoir, which the particle fluid does not know",
            "give it a pressure, or take fluid = \"fluid-lbm\"",
        ),
        Face::Pressure { outflow: Outflow::Convective, .. } => (
            "has a convective outflow, which the particle fluid does not know",
            "outflow = \"absorbing\" lets waves leave",
        ),
        _ => return None,
    };
    let message = format!("the face {} {found}", face_name(axis, side));
    Some(Problem::new(key, message).help(help))
}

/// The level beyond a face.
fn check_level(
    scene: &Scene,
    face: &Face,
    axis: usize,
    side: usize,
    level: Option<f64>,
    has_surface: bool,
    key: &str,
) -> Option<Problem> {
    let key = format!("{key}.level");
    let name = face_name(axis, side);
    let absorbs = matches!(face, Face::Pressure { outflow: Outflow::Absorbing, .. });
    // What only leaves does so wherever there is fluid.
    let inward = [1.0, -1.0][side];
    let only_leaves = matches!(face, Face::Velocity(open)
        if open.velocity[axis] * inward < 0.0 && open.course.extremes()[0] >= 0.0);
    match level {
        None if face.is_open() && has_surface && !only_leaves => {
            let found = format!("is missing: how high the fluid stands beyond the face {name}");
            Some(
                Problem::new(key, found)
                    .help("write level = \"0.3 m\" beside its velocity or pressure"),
            )
        }
        None if absorbs => {
            let found = format!(
                "is missing: the waves that leave through the face {name} are those of a free surface"
            );
            Some(Problem::new(key, found).help(
                "give the fluid a free surface by [[scene.fluid.fill]], or leave absorbing out",
            ))
        }
        Some(_) if !has_surface => {
            let found = "is given, but the fluid fills its space: it has no free surface";
            Some(
                Problem::new(key, found)
                    .help("leave it out, or give the fluid a surface by [[scene.fluid.fill]]"),
            )
        }
        Some(_) if scene.gravity == [0.0; 3] => {
            let found = "is given, but there is no gravity that makes a level";
            Some(Problem::new(key, found).help("give the scene a gravity"))
        }
        _ => None,
    }
}
