//! What this fluid cannot honour in a scene.

use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Face, Scene};

/// Checks of the scene that concern a fluid.
pub fn check_scene(scene: &Scene, problems: &mut Vec<Problem>) {
    let Some(fluid) = &scene.fluid else {
        problems.push(Problem::new("scene.fluid", "is missing, but the run has a fluid component"));
        return;
    };
    for (key, value, unit) in
        [("density", fluid.density, "kg/m³"), ("viscosity", fluid.viscosity, "Pa·s")]
    {
        if !(value.is_finite() && value > 0.0) {
            problems.push(Problem::new(
                format!("scene.fluid.{key}"),
                format!("must be positive, found {value} {unit}"),
            ));
        }
    }
    if let Some(speed) = fluid.expected_speed
        && !(speed.is_finite() && speed >= 0.0)
    {
        problems.push(Problem::new(
            "scene.fluid.expected_speed",
            format!("must not be negative, found {speed} m/s"),
        ));
    }
    for (key, vector) in [
        ("scene.gravity", scene.gravity),
        ("scene.fluid.acceleration", fluid.acceleration),
        ("scene.fluid.velocity", fluid.velocity),
    ] {
        if vector.iter().any(|x| !x.is_finite()) {
            problems.push(Problem::new(key, format!("must be finite, found {vector:?}")));
        }
    }
    check_domain(&scene.domain, problems);
    if !scene.planes.is_empty() {
        problems.push(
            Problem::new(
                "scene.planes",
                "the lattice-Boltzmann fluid knows no walls besides the domain's faces",
            )
            .help("remove the planes, or move the domain's faces to where they stand"),
        );
    }
}

/// Checks of the box and its faces.
fn check_domain(domain: &Domain, problems: &mut Vec<Problem>) {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let size = domain.size()[axis];
        if !(size.is_finite() && size > 0.0) {
            problems.push(Problem::new(
                "scene.domain.max",
                format!("the domain's edge along {name} must be positive, found {size} m"),
            ));
        }
        let [lower, upper] = &domain.faces[axis];
        if (*lower == Face::Periodic) != (*upper == Face::Periodic) {
            problems.push(Problem::new(
                format!("scene.domain.faces.{name}"),
                "one face is periodic and the other is not; a periodic face needs its opposite",
            ));
        }
    }
}
