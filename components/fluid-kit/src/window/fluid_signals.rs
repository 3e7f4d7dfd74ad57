//! Signals that every fluid tells: of parts, and of the domain's walls.

use crate::cells::grid::face_name;
use tremie_messages::Load;
use tremie_messages::scene::{Face, Scene};
use tremie_messages::start::Signal;
use tremie_messages::start::signal_row::{SignalRow, describe};

const FORCE: &str = "force of the fluid on the part, fixed or moving: gauge pressure, shear, the pressure in gaps, and \
    buoyancy as if fluid stood all around what of it lies in the domain (of a cavity the weight of what fills it; none along a \
    straight pipe from face to face); no contacts, nor what acts on surfaces that it carries; a mean over the window, of a fixed part in its last step";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the fluid on this face of the domain in the last step: gauge pressure without its hydrostatic \
    part, shear, and the pressure in gaps; no contacts";

/// Signals of each wall and symmetry plane of the domain, named `x_lower.value`; of its force [N].
pub const OF_WALLS: [SignalRow<[f64; 3]>; 3] = wall_rows(WALL);

/// Signals of each part, named `part.value`.
pub const OF_PARTS: [SignalRow<Load>; 6] = part_rows(FORCE, TORQUE);

/// Signals of a wall's force, with the meaning that a fluid gives it.
pub const fn wall_rows(meaning: &'static str) -> [SignalRow<[f64; 3]>; 3] {
    [
        ("wall_force_x", "N", meaning, |force| force[0]),
        ("wall_force_y", "N", meaning, |force| force[1]),
        ("wall_force_z", "N", meaning, |force| force[2]),
    ]
}

/// Signals of a part's load, with the meanings that a fluid gives force and torque.
pub const fn part_rows(force: &'static str, torque: &'static str) -> [SignalRow<Load>; 6] {
    [
        ("force_x", "N", force, |load| load.force[0]),
        ("force_y", "N", force, |load| load.force[1]),
        ("force_z", "N", force, |load| load.force[2]),
        ("torque_x", "N m", torque, |load| load.torque[0]),
        ("torque_y", "N m", torque, |load| load.torque[1]),
        ("torque_z", "N m", torque, |load| load.torque[2]),
    ]
}

/// Describes the signals of all walls and parts of a scene, in the order in which they are told.
pub fn describe_loads(
    scene: &Scene,
    of_walls: &[SignalRow<[f64; 3]>],
    of_parts: &[SignalRow<Load>],
) -> Vec<Signal> {
    let mut all = Vec::new();
    for (axis, side) in walls(scene) {
        all.extend(describe(of_walls, &format!("{}.", face_name(axis, side))));
    }
    for part in &scene.parts {
        all.extend(describe(of_parts, &format!("{}.", part.name)));
    }
    all
}

/// Axis and side of the faces on which the fluid acts: walls and symmetry planes.
pub fn walls(scene: &Scene) -> impl Iterator<Item = (usize, usize)> {
    let all = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    all.filter(|&(axis, side)| {
        matches!(scene.domain.faces[axis][side], Face::Wall { .. } | Face::Symmetry)
    })
}
