//! Bodies that overlap at the start.

use crate::Vec3;
use crate::bodies::body_arrays::SPHERE;
use crate::bodies::body_arrays::{BoundingSphere, Mobility, PlacedSphere};
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::material_laws;
use crate::polyhedra::{self, OverlapRoom, Polyhedra};
use tremie_grains_kit::checks::check_scene::TOUCHING;
use tremie_grains_kit::neighbours::cell_pairs::CellPairs;
use tremie_grains_kit::neighbours::linked_cells::LinkedCells;
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls;
use tremie_grains_kit::space::solid_part::SolidPart;
use tremie_messages::scene::Motion;
use tremie_messages::{
    Problem,
    scene::{Domain, Scene},
};
use tremie_team::Team;

/// Checks that bodies overlap neither each other, unless none of two is moved by forces, nor walls
/// and parts. Of spheres and walls the scene's own check tells.
pub(crate) fn check(
    scene: &Scene,
    spheres: &[PlacedSphere],
    parts: &[PlacedPart],
    team: &mut Team,
) -> Result<(), Vec<Problem>> {
    let polyhedra = Polyhedra::new(scene, spheres, team);
    let problems = inside(scene, spheres, &polyhedra);
    if !problems.is_empty() {
        return Err(problems);
    }
    check_pairs(scene, spheres, &polyhedra)?;
    check_parts(scene, spheres, parts, &polyhedra)
}

fn check_pairs(
    scene: &Scene,
    spheres: &[PlacedSphere],
    polyhedra: &Polyhedra,
) -> Result<(), Vec<Problem>> {
    let Some((a, b, overlap, count)) = deepest_overlap(&scene.domain, spheres, polyhedra) else {
        return Ok(());
    };
    let of = |i: usize| format!("body {i} (of \"{}\")", scene.bodies[spheres[i].set].name);
    let others = match count {
        1 => String::new(),
        _ => format!("; {} more pairs overlap", count - 1),
    };
    let message = format!("{} and {} overlap by {overlap:.3e} m{others}", of(a), of(b));
    let key = format!("scene.bodies[{}].placement", spheres[b].set);
    Err(vec![Problem::new(key, message)])
}

/// Checks that no free body stands in a part at the start.
fn check_parts(
    scene: &Scene,
    spheres: &[PlacedSphere],
    parts: &[PlacedPart],
    polyhedra: &Polyhedra,
) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    let (numbers, mut room) = (numbers(spheres), OverlapRoom::default());
    let free = spheres.iter().enumerate().filter(|(_, sphere)| sphere.mobility().is_free());
    for (id, sphere) in free {
        for (part, placed) in scene.parts.iter().zip(parts) {
            let (overlap, size) = match numbers[id] {
                SPHERE => {
                    (sphere.ball.radius - placed.clearance(sphere.ball.x).0, sphere.ball.radius)
                }
                grain => {
                    let solid = polyhedra.solid(grain as usize);
                    let overlap = polyhedra::with_part(solid, sphere.ball.x, placed, &mut room);
                    (overlap, solid.inradius())
                }
            };
            if overlap > TOUCHING * size {
                let message = format!(
                    "puts body {id} (of \"{}\") {overlap:.3e} m into part \"{}\"",
                    scene.bodies[sphere.set].name, part.name
                );
                let key = format!("scene.bodies[{}].placement", sphere.set);
                problems.push(Problem::new(key, message).help("move the body out of the part"));
            }
        }
    }
    problems.truncate(MOST_PROBLEMS);
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// More bodies in parts are not listed one by one.
const MOST_PROBLEMS: usize = 20;

/// The pair with the deepest overlap beyond touching, its overlap, and the number of such pairs.
fn deepest_overlap(
    domain: &Domain,
    spheres: &[PlacedSphere],
    polyhedra: &Polyhedra,
) -> Option<(usize, usize, f64, usize)> {
    let bounds = PeriodicBox::new(domain);
    let balls: Vec<BoundingSphere> = spheres.iter().map(|s| s.ball).collect();
    let mobility: Vec<Mobility> = spheres.iter().map(PlacedSphere::mobility).collect();
    if balls.is_empty() {
        return None;
    }
    let spans = balls.iter().map(|ball| [2.0 * ball.radius; 2]);
    let mut cells = LinkedCells::new(bounds.clone(), Skins::new(spans, 0.0, 0.0));
    cells.sort(&balls);
    let (numbers, mut room) = (numbers(spheres), OverlapRoom::default());
    let mut list = CellPairs::default();
    list.fill(&cells, &bounds.shifts, &balls, &mobility);
    let (mut worst, mut count) = (None::<(usize, usize, f64)>, 0);
    for i in 0..balls.len() {
        for k in list.row(i) {
            let (j, image) = (list.neighbours[k].other as usize, list.neighbours[k].image);
            let d = balls[j].x + bounds.shifts[image as usize] - balls[i].x;
            let (overlap, size) = polyhedra::of_bodies(
                polyhedra,
                [(numbers[i], &balls[i]), (numbers[j], &balls[j])],
                d,
                &mut room,
            )
            .unwrap_or_else(|| of_balls(&balls[i], &balls[j], d));
            if overlap <= TOUCHING * size {
                continue;
            }
            count += 1;
            if worst.is_none_or(|(_, _, most)| overlap > most) {
                worst = Some((i.min(j), i.max(j), overlap));
            }
        }
    }
    worst.map(|(i, j, overlap)| (i, j, overlap, count))
}

/// Overlap of two spheres `way` apart, and the radius that it is measured by [m].
fn of_balls(a: &BoundingSphere, b: &BoundingSphere, way: Vec3) -> (f64, f64) {
    (a.radius + b.radius - way.norm_squared().sqrt(), a.radius.min(b.radius))
}

/// Numbers of polyhedra by ids.
fn numbers(bodies: &[PlacedSphere]) -> Vec<u32> {
    let mut next = 0..;
    let number = |body: &PlacedSphere| body.solid.and_then(|_| next.next()).unwrap_or(SPHERE);
    bodies.iter().map(number).collect()
}

/// Checks that centroids lie in the domain, and all of a free polyhedron on the right side of
/// walls.
fn inside(scene: &Scene, placed: &[PlacedSphere], polyhedra: &Polyhedra) -> Vec<Problem> {
    let mut problems = Vec::new();
    let (bounds, walls) = (PeriodicBox::new(&scene.domain), plane_walls::of_scene(scene));
    let surfaces = material_laws::surfaces(scene);
    for (number, grain) in polyhedra.grains().iter().enumerate() {
        let body = &placed[grain.id as usize];
        let name = &scene.bodies[body.set].name;
        let mut problem = |message: String| {
            let key = format!("scene.bodies[{}].placement", body.set);
            problems.push(Problem::new(key, message));
        };
        let x: Vec3 = body.ball.x;
        if !bounds.contains(x) {
            problem(format!("puts body {} (of \"{name}\") outside the domain", grain.id));
            continue;
        }
        let solid = polyhedra.solid(number);
        for (wall, surface) in walls.iter().zip(&surfaces) {
            let depth = solid.support(-wall.normal) - (x.dot(&wall.normal) - wall.offset);
            if body.motion == Motion::Free && depth > TOUCHING * solid.inradius() {
                let into = &surface.name;
                problem(format!(
                    "puts body {} (of \"{name}\") {depth:.3e} m into {into}",
                    grain.id
                ));
            }
        }
    }
    problems.truncate(MOST_PROBLEMS);
    problems
}
