//! Checks of surfaces that deform.

use crate::bodies::deformable_surface::{DeformableSurface, area_vectors};
use crate::bodies::slider::unit;
use crate::contact::contact_law::Law;
use crate::contact::springs::Reduced;
use crate::setup::check::MIN_STEPS_PER_CONTACT;
use crate::setup::check_law;
use crate::setup::material_pairs::BodyStatistics;
use crate::solver::clumps::{self, Whole};
use core::f64::consts::PI;
use tremie_geometry::{Mesh, Surface};
use tremie_grains_kit::math::numbers::is_positive;
use tremie_messages::{
    Problem,
    scene::{BodySet, Face, Motion, Scene, Slider},
};

/// Everything that is wrong with the surfaces of a scene that is right otherwise.
pub(crate) fn check(scene: &Scene, surfaces: &[DeformableSurface], dt: f64) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (k, surface) in surfaces.iter().enumerate() {
        one(&format!("surfaces[{k}]"), scene, surface, dt, &mut problems);
    }
    let periodic = |face: &Face| *face == Face::Periodic;
    if !surfaces.is_empty() && scene.domain.faces.iter().flatten().any(periodic) {
        let message = "wraps around, but surfaces that deform do not";
        let help = "make the faces walls or symmetry planes";
        problems.push(Problem::new("scene.domain", message).help(help));
    }
    problems
}

fn one(
    key: &str,
    scene: &Scene,
    surface: &DeformableSurface,
    dt: f64,
    problems: &mut Vec<Problem>,
) {
    let before = problems.len();
    let mesh = Mesh {
        vertices: surface.vertices.iter().map(|&vertex| vertex.into()).collect(),
        triangles: surface.triangles.clone(),
    };
    if let Err(error) = Surface::new(mesh) {
        problems.extend(error.problems(&format!("{key}.triangles")));
    }
    if !is_positive(surface.seat_stiffness) {
        let message = format!("is {} N/m3, expected a positive number", surface.seat_stiffness);
        problems.push(Problem::new(format!("{key}.seat_stiffness"), message));
    }
    let carrier = scene.parts.get(surface.carrier).map(|part| &part.motion);
    let Some(Motion::Slider(slider)) = carrier else {
        let message = format!("is {}, and no part of that number is a slider", surface.carrier);
        let help = "name the slider that the surface is fixed to";
        problems.push(Problem::new(format!("{key}.carrier"), message).help(help));
        return;
    };
    let sets = scene.bodies.iter().zip(clumps::wholes(scene));
    for (set, whole) in sets.filter(|(set, _)| set.motion == Motion::Free) {
        meets(key, scene, surface, (set, whole, dt), problems);
    }
    if problems.len() == before {
        seats(key, surface, (slider, dt), problems);
    }
}

/// Checks the contacts with the spheres of a set.
fn meets(
    key: &str,
    scene: &Scene,
    surface: &DeformableSurface,
    (set, whole, dt): (&BodySet, Option<Whole>, f64),
    problems: &mut Vec<Problem>,
) {
    let (a, b) = (&set.material, &surface.material);
    let Some(law) = scene.law(a, b) else {
        let message = format!("has no law for \"{a}\" and \"{b}\", but they may touch");
        let help = format!("add a contact between \"{a}\" and \"{b}\"");
        problems.push(Problem::new("scene.contacts", message).help(help));
        return;
    };
    let Some((mass, radius)) = BodyStatistics::lightest(scene, set, whole) else { return };
    let speed = slowest(scene);
    let pair = Reduced { root_mass: mass.sqrt(), radius, mean_mass: mass };
    let law = Law::new(law);
    if law.spring.law().is_for_rigid_spheres() {
        let name = law.spring.law().name();
        let message = format!("is met under {name}, which has no form for it");
        problems.push(Problem::new(key, message).help(check_law::LINEAR));
        return;
    }
    if law.spring.law().neck(pair) > 0.0 {
        let name = law.spring.law().name();
        let message =
            format!("meets \"{a}\" under {name}, but surfaces that deform do not adhere yet");
        problems.push(Problem::new(key, message).help("give the pair a law without adhesion"));
        return;
    }
    too_few(key, "a sphere", law.contact_time(pair, speed), dt, problems);
}

/// Relative speed for which collisions under Hertz's law are looked at [m/s].
fn slowest(scene: &Scene) -> f64 {
    let speed = BodyStatistics::of(scene).speed;
    if speed > 0.0 { 2.0 * speed } else { 0.01 }
}

/// Checks the contact of the whole surface with a seat across the axis.
fn seats(
    key: &str,
    surface: &DeformableSurface,
    (slider, dt): (&Slider, f64),
    problems: &mut Vec<Problem>,
) {
    let axis = unit(slider.axis);
    // As much of it faces one way as the other: it is closed.
    let facing: f64 = area_vectors(surface).map(|area| area.dot(&axis).max(0.0)).sum();
    let time = PI * (slider.mass / (surface.seat_stiffness * facing)).sqrt();
    too_few(key, "the seat", time, dt, problems);
}

fn too_few(key: &str, what: &str, time: f64, dt: f64, problems: &mut Vec<Problem>) {
    if time / dt < MIN_STEPS_PER_CONTACT {
        let message = format!(
            "meets {what} in a collision of {time:.3e} s, {:.1} time steps of {dt:.3e} s",
            time / dt
        );
        let help = format!("use steps of {:.3e} s or less", time / 15.0);
        problems.push(Problem::new(key, message).help(help));
    }
}
