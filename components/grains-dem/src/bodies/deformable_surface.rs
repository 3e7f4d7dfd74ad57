//! Surfaces that deform: what they are, and what can be wrong with them.

use crate::Vec3;
use crate::bodies::slider::unit;
use crate::contact::contact_law::Reduced;
use crate::setup::check::{MIN_STEPS_PER_CONTACT, is_positive};
use crate::setup::material_pairs::{Population, contact_time};
use crate::solver::clumps::{self, Whole};
use core::f64::consts::PI;
use tremie_geometry::{Mesh, Surface};
use tremie_messages::{
    Problem,
    scene::{BodySet, Face, Motion, Scene, Slider},
};

/// A closed surface of triangles whose vertices somebody else moves, as those of a rubber seal on a
/// slider. Spheres meet its facets under the law of their materials. Parts that stand still and walls
/// are its seat: they push its vertices out by a stiffness for each area, without friction.
///
/// Its connectivity stays. It is the whole surface, also where symmetry planes cut its carrier: what
/// spheres do to a facet counts with what their images do, the seat acts on the vertices on both
/// sides.
#[derive(Clone, Debug, PartialEq)]
pub struct DeformableSurface {
    /// Vertices of each triangle, counterclockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Vertices at the start [m], in the world's frame; their shape is the one that areas are of.
    pub vertices: Vec<[f64; 3]>,
    /// Index into the scene's list of parts of the slider that carries it.
    pub carrier: usize,
    /// Its material.
    pub material: String,
    /// Pressure of the seat over the depth of a vertex in it [N/m³]: a vertex has the third of the area of
    /// each facet at it, as far as the facet faces the seat.
    pub seat_stiffness: f64,
}

/// A surface at the end of a substep.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceState<'a> {
    /// Vertices [m], in the world's frame.
    pub vertices: &'a [[f64; 3]],
    /// Their velocities [m/s].
    pub velocities: &'a [[f64; 3]],
    /// Force on the carrier besides that of contacts, as that of a fluid on the surface [N].
    pub carrier_force: [f64; 3],
}

/// A force on a facet, one for each contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetLoad {
    /// Index of the triangle.
    pub facet: u32,
    /// Force [N]; of spheres at a carrier that symmetry planes cut, that of their images besides.
    pub force: [f64; 3],
    /// Where it acts [m].
    pub point: [f64; 3],
    /// How fast the normal force falls as the facet retreats through the substep [N/m], by the spring and by the dashpot
    /// over the substep's length; of spheres at a carrier that symmetry planes cut, that of their images besides.
    pub stiffness: f64,
}

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

/// Mean length of its edges [m].
pub(crate) fn mean_edge(surface: &DeformableSurface) -> f64 {
    let edges = surface.triangles.iter().map(|triangle| {
        let [a, b, _] = triangle.map(|v| Vec3::from(surface.vertices[v as usize]));
        (b - a).norm_squared().sqrt()
    });
    edges.sum::<f64>() / surface.triangles.len() as f64
}

fn one(
    key: &str,
    scene: &Scene,
    surface: &DeformableSurface,
    dt: f64,
    problems: &mut Vec<Problem>,
) {
    let before = problems.len();
    let mesh = Mesh { vertices: surface.vertices.clone(), triangles: surface.triangles.clone() };
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
    let Some((mass, radius)) = Population::lightest(set, whole) else { return };
    let speed = slowest(scene);
    let pair = Reduced { root_mass: mass.sqrt(), radius };
    too_few(key, "a sphere", contact_time(law, pair, speed), dt, problems);
}

/// Relative speed for which collisions under Hertz's law are looked at [m/s].
fn slowest(scene: &Scene) -> f64 {
    let speed = Population::of(scene).speed;
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

/// Area of each triangle times its normal [m²].
pub(crate) fn area_vectors(surface: &DeformableSurface) -> impl Iterator<Item = Vec3> + '_ {
    surface.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|v| Vec3::from(surface.vertices[v as usize]));
        (b - a).cross(&(c - a)) * 0.5
    })
}
