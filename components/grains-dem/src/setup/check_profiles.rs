//! Checks of profiles: what these grains can measure.

use tremie_messages::{Problem, scene::Scene};

/// Profiles need grains that each are a sphere, or a cylinder of a plane scene: contacts of
/// polyhedra have areas, not points, and the pieces of a clump push each other in ways that are not
/// known.
pub(crate) fn profiles(scene: &Scene, problems: &mut Vec<Problem>) {
    let Some(profile) = scene.profiles.first() else { return };
    let name = &profile.name;
    let clump = scene.bodies.iter().find_map(|set| Some((set, set.clump.as_ref()?)));
    let what = if scene.has_polyhedra() {
        let round = if scene.domain.across.is_some() { "cylinders" } else { "spheres" };
        format!("measures {round} alone, and the scene has polyhedra or prisms")
    } else if let Some((set, clump)) = clump {
        format!("measures grains one by one, and \"{}\" is part of the clump \"{clump}\"", set.name)
    } else {
        return;
    };
    let message = format!("the profile \"{name}\" {what}");
    let help = "leave out the profiles, or measure with probes (scene.probes), which count these bodies too";
    problems.push(Problem::new("scene.profiles[0].name", message).help(help));
}

/// What the profiles of a valid scene leave out.
#[cfg(feature = "component")]
pub(crate) fn left_out(scene: &Scene) -> Option<String> {
    let is_rubbed = !scene.profiles.is_empty() && !scene.surfaces.is_empty();
    let text = "profiles count no contacts of grains with surfaces that deform: coordination and contact stress \
                beside them are too small";
    is_rubbed.then(|| text.into())
}
