//! Bodies that overlap at the start.

use crate::{
    bodies::{Ball, Mobility, PlacedSphere},
    cells::Cells,
    parts::PlacedPart,
    periodic::PeriodicBox,
    rows::Rows,
};
use tremie_messages::{
    Problem,
    scene::{Domain, Scene},
};

/// Overlap at the start, over the smaller radius, that passes as touching.
pub(crate) const TOUCHING: f64 = 0.01;

/// Checks that no two bodies overlap at the start, unless neither is moved by forces.
pub(crate) fn check(scene: &Scene, spheres: &[PlacedSphere]) -> Result<(), Vec<Problem>> {
    let Some((a, b, overlap, count)) = deepest_overlap(&scene.domain, spheres) else {
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
pub(crate) fn check_parts(
    scene: &Scene,
    spheres: &[PlacedSphere],
    parts: &[PlacedPart],
) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    let free = spheres.iter().enumerate().filter(|(_, sphere)| sphere.mobility().is_free());
    for (id, sphere) in free {
        for (part, placed) in scene.parts.iter().zip(parts) {
            let overlap = sphere.ball.radius - placed.clearance(sphere.ball.x).0;
            if overlap > TOUCHING * sphere.ball.radius {
                let message = format!(
                    "puts body {id} (of \"{}\") {overlap:.3e} m into part \"{}\"",
                    scene.bodies[sphere.set].name, part.name
                );
                let key = format!("scene.bodies[{}].placement", sphere.set);
                problems.push(Problem::new(key, message));
            }
        }
    }
    problems.truncate(MOST_PROBLEMS);
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// More bodies in parts are not listed one by one.
const MOST_PROBLEMS: usize = 20;

/// The pair with the deepest overlap beyond touching, its overlap, and how many there are.
fn deepest_overlap(
    domain: &Domain,
    spheres: &[PlacedSphere],
) -> Option<(usize, usize, f64, usize)> {
    let bounds = PeriodicBox::new(domain);
    let balls: Vec<Ball> = spheres.iter().map(|s| s.ball).collect();
    let mobility: Vec<Mobility> = spheres.iter().map(PlacedSphere::mobility).collect();
    let largest = balls.iter().fold(0.0, |d: f64, b| d.max(2.0 * b.radius));
    if balls.is_empty() {
        return None;
    }
    let mut cells = Cells::new(bounds.clone(), largest, balls.len());
    cells.sort(&balls);
    let mut list = Rows::default();
    list.fill(&cells, &bounds.shifts, &balls, &mobility, 0.0);
    let (mut worst, mut count) = (None::<(usize, usize, f64)>, 0);
    for i in 0..balls.len() {
        for k in list.row(i) {
            let (j, image) = (list.neighbours[k].other as usize, list.neighbours[k].image);
            let d = balls[j].x + bounds.shifts[image as usize] - balls[i].x;
            let overlap = balls[i].radius + balls[j].radius - d.norm_squared().sqrt();
            if overlap <= TOUCHING * balls[i].radius.min(balls[j].radius) {
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
