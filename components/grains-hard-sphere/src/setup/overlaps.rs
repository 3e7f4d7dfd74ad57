//! Bodies that overlap at the start: refused where they do much, pushed apart where they touch.

use crate::Vec3;
use crate::bodies::hard_parts::HardPart;
use crate::cells::body_cells::BodyCells;
use crate::setup::placement::PlacedBody;
use tremie_grains_kit::checks::check_scene::TOUCHING;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls;
use tremie_messages::Problem;
use tremie_messages::scene::{Motion, Scene};

/// Sweeps in which bodies that touch are pushed apart.
const SWEEPS: usize = 200;

/// Overlap over the smaller radius that is left: rounding.
const CLEAR: f64 = 1e-12;

/// Cells with all bodies in them, for bodies that the motions of sets leave free.
pub fn cells_of(scene: &Scene, placed: &[PlacedBody]) -> BodyCells {
    let largest = placed.iter().fold(0.0, |d: f64, body| d.max(2.0 * body.ball.radius));
    let bounds = PeriodicBox::new(&scene.domain);
    let diameter = if largest > 0.0 { largest } else { scene.domain.size()[0] };
    BodyCells::new(bounds, placed.len(), diameter, scene.domain.across)
}

/// Pushes bodies apart that overlap by no more than touching.
///
/// # Errors
/// Bodies that overlap each other or a part by more.
pub fn separate(
    scene: &Scene,
    placed: &mut [PlacedBody],
    parts: &[HardPart],
) -> Result<(), Vec<Problem>> {
    let mut cells = cells_of(scene, placed);
    for (k, body) in placed.iter().enumerate() {
        cells.insert(k, cells.cell_of(body.ball.x));
    }
    check_pairs(scene, placed, &cells)?;
    check_parts(scene, placed, parts)?;
    for _ in 0..SWEEPS {
        if !sweep(scene, placed, &mut cells) {
            break;
        }
    }
    Ok(())
}

fn is_free(scene: &Scene, body: &PlacedBody) -> bool {
    scene.bodies[body.set].motion == Motion::Free
}

/// Pushes apart each pair that overlaps, and bodies out of walls; false if there was none.
fn sweep(scene: &Scene, placed: &mut [PlacedBody], cells: &mut BodyCells) -> bool {
    let walls = plane_walls::of_scene(scene);
    let mut any = false;
    for i in 0..placed.len() {
        let mut touched: Vec<(usize, Vec3)> = Vec::new();
        cells.around(cells.home(i), |j, shift| {
            if j > i && overlap(&placed[i], &placed[j], shift) > CLEAR * placed[i].ball.radius {
                touched.push((j, shift));
            }
        });
        touched.sort_by_key(|(j, _)| *j);
        for (j, shift) in touched {
            let free = [i, j].map(|k| is_free(scene, &placed[k]));
            let depth = overlap(&placed[i], &placed[j], shift);
            let way = placed[j].ball.x + shift - placed[i].ball.x;
            let length = way.norm_squared().sqrt();
            if free == [false, false] || length == 0.0 || depth <= 0.0 {
                continue;
            }
            any = true;
            let share = if free == [true, true] { 0.5 } else { 1.0 };
            let push = way * (share * depth / length);
            if free[0] {
                placed[i].ball.x -= push;
            }
            if free[1] {
                placed[j].ball.x += push;
            }
        }
        for wall in &walls {
            let depth = wall.overlap(&placed[i].ball);
            if is_free(scene, &placed[i]) && depth > CLEAR * placed[i].ball.radius {
                placed[i].ball.x += wall.normal * depth;
                any = true;
            }
        }
    }
    any
}

/// Overlap of two bodies, the other one seen at a shift [m].
fn overlap(one: &PlacedBody, other: &PlacedBody, shift: Vec3) -> f64 {
    let way = other.ball.x + shift - one.ball.x;
    one.ball.radius + other.ball.radius - way.norm_squared().sqrt()
}

fn check_pairs(
    scene: &Scene,
    placed: &[PlacedBody],
    cells: &BodyCells,
) -> Result<(), Vec<Problem>> {
    let (mut worst, mut count) = (None::<(usize, usize, f64)>, 0);
    for i in 0..placed.len() {
        cells.around(cells.home(i), |j, shift| {
            let meets = is_free(scene, &placed[i]) || is_free(scene, &placed[j]);
            let depth = overlap(&placed[i], &placed[j], shift);
            let smaller = placed[i].ball.radius.min(placed[j].ball.radius);
            if j > i && meets && depth > TOUCHING * smaller {
                count += 1;
                if worst.is_none_or(|(_, _, most)| depth > most) {
                    worst = Some((i, j, depth));
                }
            }
        });
    }
    let Some((i, j, depth)) = worst else { return Ok(()) };
    let of = |k: usize| format!("body {k} (of \"{}\")", scene.bodies[placed[k].set].name);
    let others =
        if count > 1 { format!("; {} more pairs overlap", count - 1) } else { String::new() };
    let message = format!("{} and {} overlap by {depth:.3e} m{others}", of(i), of(j));
    let key = format!("scene.bodies[{}].placement", placed[j].set);
    Err(vec![Problem::new(key, message).help("move them apart: hard spheres cannot overlap")])
}

fn check_parts(
    scene: &Scene,
    placed: &[PlacedBody],
    parts: &[HardPart],
) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    for (id, body) in placed.iter().enumerate().filter(|(_, body)| is_free(scene, body)) {
        for (part, of) in parts.iter().zip(&scene.parts) {
            let depth = body.ball.radius - part.shape().clearance(body.ball.x).0;
            if depth > TOUCHING * body.ball.radius && problems.len() < MOST_PROBLEMS {
                let (set, name) = (&scene.bodies[body.set].name, &of.name);
                let message =
                    format!("puts body {id} (of \"{set}\") {depth:.3e} m into part \"{name}\"");
                let key = format!("scene.bodies[{}].placement", body.set);
                problems.push(Problem::new(key, message).help("move the body out of the part"));
            }
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

/// More bodies in parts are not listed one by one.
const MOST_PROBLEMS: usize = 20;
