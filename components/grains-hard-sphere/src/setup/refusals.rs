//! What hard spheres cannot do: one clear problem each.

use tremie_messages::Problem;
use tremie_messages::scene::{ContactLaw, Damping, Motion, Placement, ProbeShape, Scene, Spring};

/// Remedy that always works.
const OTHER: &str = "take grains-dem for the role grains";

/// Problems of all that a scene asks for and hard spheres do not have.
pub fn refusals(scene: &Scene) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (i, set) in scene.bodies.iter().enumerate() {
        let key = format!("scene.bodies[{i}]");
        if let Some(clump) = &set.clump {
            let message = format!("is the clump \"{clump}\", but hard spheres collide one by one");
            problems.push(refused(format!("{key}.clump"), message, "leave the clump out"));
        }
        if matches!(set.placement, Placement::Polyhedra(_)) {
            let message = "are polyhedra, but hard spheres are round";
            problems.push(refused(format!("{key}.placement"), message, "make them spheres"));
        }
        if matches!(set.motion, Motion::Slider(_)) {
            let message = "is that of a slider, but hard spheres do not slide on an axis";
            problems.push(refused(format!("{key}.motion"), message, "prescribe the motion"));
        }
    }
    for (i, pair) in scene.contacts.iter().enumerate() {
        // A manifest may give one law to many pairs: it is told once.
        if scene.contacts[..i].iter().any(|before| before.law == pair.law) {
            continue;
        }
        law(&format!("scene.contacts[{i}].law"), &pair.law, &mut problems);
    }
    let mut whole = |is_there: bool, key: &str, message: &str, help: &str| {
        if is_there {
            problems.push(refused(key.into(), message, help));
        }
    };
    whole(
        !scene.inlets.is_empty(),
        "scene.inlets[0]",
        "feeds spheres, but hard spheres neither come nor go during a run",
        "place all spheres at the start",
    );
    whole(
        !scene.outlets.is_empty(),
        "scene.outlets[0]",
        "removes spheres, but hard spheres neither come nor go during a run",
        "leave the outlet out",
    );
    whole(
        !scene.drag_bands.is_empty(),
        "scene.drag_bands[0]",
        "brakes grains by a drag, but between collisions hard spheres know weight and fluid alone",
        "leave the band out",
    );
    whole(
        !scene.surfaces.is_empty(),
        "scene.surfaces[0]",
        "deforms, but hard spheres press on nothing for a time, so that rubber would not feel them",
        "leave out the surface and the rubber",
    );
    whole(
        !scene.profiles.is_empty(),
        "scene.profiles[0]",
        "measures stresses of contacts, of which hard spheres have none at a moment",
        "leave the profile out",
    );
    probes(scene, &mut problems);
    problems
}

/// Probes at which grains would be measured.
fn probes(scene: &Scene, problems: &mut Vec<Problem>) {
    for (i, probe) in scene.probes.iter().enumerate() {
        let what = match probe.shape {
            ProbeShape::Section { .. } => "section",
            ProbeShape::Region { .. } => "region",
            ProbeShape::Ring(_) => "ring",
            // Those are the fluid's.
            ProbeShape::Point(_) | ProbeShape::Line { .. } | ProbeShape::Profile { .. } => continue,
        };
        if scene.fluid.is_some() && what == "section" {
            // The fluid measures there; its flow is not these grains' matter.
            continue;
        }
        let message = format!("is a {what}, at which hard spheres are not measured");
        problems.push(refused(format!("scene.probes[{i}].{what}"), message, "leave the probe out"));
    }
}

fn refused(key: String, message: impl Into<String>, help: &str) -> Problem {
    Problem::new(key, message).help(format!("{help}, or {OTHER}"))
}

/// Of a contact law hard spheres take restitution and friction; what would change a collision
/// otherwise is refused.
fn law(key: &str, law: &ContactLaw, problems: &mut Vec<Problem>) {
    match law.spring {
        Spring::Linear { .. } | Spring::LinearNoHistory { .. } | Spring::Hertz { .. } => {}
        Spring::Jkr { work_of_adhesion, .. } => {
            let message = format!(
                "has an adhesion of {work_of_adhesion} J/m2, but hard spheres touch for no time and cannot hold each other"
            );
            problems.push(refused(format!("{key}.spring"), message, "give a law without adhesion"));
        }
        Spring::Chen { gap, .. } => {
            let message = format!(
                "is that of Chen et al., a spring that acts from a gap of {gap} m on, but hard spheres have no spring"
            );
            let help = "give a linear law with a restitution";
            problems.push(refused(format!("{key}.spring"), message, help));
        }
    }
    let found = match law.damping {
        Damping::Restitution(e) => {
            if !(e > 0.0 && e <= 1.0) {
                let message = format!("is {e}, expected a coefficient of restitution in (0, 1]");
                problems.push(Problem::new(format!("{key}.damping.restitution"), message));
            }
            None
        }
        Damping::Coefficients { .. } => Some("coefficients of dashpots"),
        Damping::Ratio(_) => Some("a damping ratio"),
    };
    if let Some(found) = found {
        let message =
            format!("gives {found}, expected a restitution: a hard collision has no duration");
        problems.push(refused(format!("{key}.damping"), message, "give the restitution"));
    }
    let mu = law.friction;
    if !(mu >= 0.0 && mu.is_finite()) {
        let message = format!("is {mu}, expected 0 or more");
        problems.push(Problem::new(format!("{key}.friction"), message));
    }
    if law.rolling_friction > 0.0 {
        let message =
            format!("is {}, expected 0: a torque needs a contact that lasts", law.rolling_friction);
        problems.push(refused(format!("{key}.rolling_friction"), message, "make it 0"));
    }
}
