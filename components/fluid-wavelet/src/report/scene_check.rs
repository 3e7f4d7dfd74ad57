//! Demands of a scene that this gas cannot meet.

use std::collections::BTreeSet;
use tremie_fluid_kit::cells::grid::face_name;
use tremie_fluid_kit::checks::material_check::check_material;
use tremie_messages::Problem;
use tremie_messages::scene::{Face, FluidMaterial, PartBoundary, Profile, Scene};

/// Largest Mach number of a vortex: above it the gas at its centre would be colder than none.
const VORTEX_MACH: f64 = 1.3;

/// Checks of the scene that concern a gas, which may be without friction.
pub fn check_scene(scene: &Scene, inviscid: bool, problems: &mut Vec<Problem>) {
    let Some(fluid) = check_material(scene, problems) else { return };
    if fluid.gas.is_none() {
        let found =
            "is missing: fluid-wavelet computes a gas, of which it has to know the pressure";
        let help = "write [scene.fluid.gas] with pressure = \"101325 Pa\", or take another fluid";
        problems.push(Problem::new("scene.fluid.gas", found).help(help));
        return;
    }
    check_gas(fluid, problems);
    check_surfaces(scene, inviscid, problems);
    check_faces(scene, problems);
    for (index, part) in scene.parts.iter().enumerate() {
        if part.boundary != PartBoundary::Wall {
            let found = format!("{} lets fluid through, but the gas knows walls only", part.name);
            let key = format!("scene.parts[{index}].boundary");
            problems.push(Problem::new(key, found).help("make it a wall"));
        }
    }
    for (index, set) in scene.bodies.iter().enumerate() {
        if let Some(clump) = &set.clump {
            let found = format!(
                "the bodies belong to the clump {clump}, which the gas would take for bodies of their own"
            );
            let key = format!("scene.bodies[{index}].clump");
            problems.push(Problem::new(key, found).help("take single bodies"));
        }
    }
    if !scene.gaps.is_empty() {
        let found = "the gas has no model of gaps that open and close";
        problems.push(Problem::new("scene.gaps[0]", found).help("leave scene.gaps out"));
    }
}

/// The start of the gas.
fn check_gas(fluid: &FluidMaterial, problems: &mut Vec<Problem>) {
    let Some(gas) = &fluid.gas else { return };
    if !fluid.fill.is_empty() {
        let found = "a gas fills all its space: it has no free surface";
        let help = "leave the regions out, or take fluid = \"fluid-pic\"";
        problems.push(Problem::new("scene.fluid.fill[0]", found).help(help));
    }
    if fluid.pressure <= -gas.pressure {
        let found =
            format!("{} Pa below the gas's own {} Pa leave no gas", -fluid.pressure, gas.pressure);
        let help = "it is a gauge pressure: 0 Pa begins with that of scene.fluid.gas";
        problems.push(Problem::new("scene.fluid.pressure", found).help(help));
    }
    if let Some(vortex) = &gas.vortex {
        let sound = (gas.heat_ratio * gas.pressure / fluid.density).sqrt();
        let most = VORTEX_MACH.min((1.6 / ((gas.heat_ratio - 1.0) * 1.0_f64.exp())).sqrt()) * sound;
        if vortex.speed.abs() > most {
            let found = format!(
                "found {} m/s, expected at most {most:.4} m/s: the pressure at the centre would be gone",
                vortex.speed
            );
            problems.push(Problem::new("scene.fluid.gas.vortex.speed", found));
        }
    }
}

/// Surfaces with a temperature of their own.
fn check_surfaces(scene: &Scene, inviscid: bool, problems: &mut Vec<Problem>) {
    let gas = scene.fluid.as_ref().and_then(|fluid| fluid.gas.as_ref());
    let bodies = scene.bodies.iter().map(|set| &set.material);
    let known: BTreeSet<_> = bodies.chain(scene.parts.iter().map(|part| &part.material)).collect();
    for material in gas.into_iter().flat_map(|gas| gas.surface_temperatures.keys()) {
        let key = format!("scene.fluid.gas.surface_temperatures.{material}");
        if !known.contains(material) {
            let found = format!("no body and no part is of the material {material}");
            let names: Vec<_> = known.iter().map(|name| name.as_str()).collect();
            let help = if names.is_empty() {
                "there are none; faces and planes take no heat".to_string()
            } else {
                format!("bodies and parts here are of: {}", names.join(", "))
            };
            problems.push(Problem::new(key, found).help(help));
        } else if inviscid {
            let found = "a gas without friction conducts no heat either";
            let help = "leave it out, or leave inviscid = true out of the settings";
            problems.push(Problem::new(key, found).help(help));
        }
    }
}

fn check_faces(scene: &Scene, problems: &mut Vec<Problem>) {
    let domain = &scene.domain;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for (side, end) in ["lower", "upper"].into_iter().enumerate() {
            let key = format!("scene.domain.{name}.{end}");
            let mut refuse = |found: &str, help: &str| {
                let found = format!("the face {} {found}", face_name(axis, side));
                problems.push(Problem::new(&key, found).help(help));
            };
            match &domain.faces[axis][side] {
                Face::Reservoir(_) => refuse(
                    "has a reservoir, which the gas does not know",
                    "give it a pressure, or take fluid = \"fluid-lbm\"",
                ),
                Face::Velocity(open) if open.profile == Profile::Parabolic => refuse(
                    "has a parabolic profile, which the gas does not know",
                    "profile = \"uniform\"",
                ),
                _ => {}
            }
            if domain.levels[axis][side].is_some() {
                refuse("has a level, but a gas has no free surface", "leave the level out");
            }
        }
    }
}
