//! The numbers of a scene's fluid.

use tremie_messages::Problem;
use tremie_messages::scene::{FluidMaterial, Scene};

/// The fluid of a scene, if there is one; its material, its speeds and what drives it are checked.
pub fn check_material<'a>(
    scene: &'a Scene,
    problems: &mut Vec<Problem>,
) -> Option<&'a FluidMaterial> {
    let Some(fluid) = &scene.fluid else {
        problems.push(Problem::new("scene.fluid", "is missing, but the run has a fluid component"));
        return None;
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
    Some(fluid)
}
