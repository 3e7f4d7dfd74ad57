//! Signals that every fluid tells: of parts, and of the domain's walls.

use tremie_messages::Load;
use tremie_messages::scene::{Face, Scene};
use tremie_messages::start::SignalRow;

const FORCE: &str = "force of the fluid on the part, fixed or moving: gauge pressure, shear, the pressure in gaps, and \
    buoyancy as if fluid stood all around what of it lies in the domain (of a cavity the weight of what fills it; none along a \
    straight pipe from face to face); no contacts, nor what acts on surfaces that it carries; a mean over the window, of a fixed part in its last step";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the fluid on this face of the domain in the last step: gauge pressure without its hydrostatic \
    part, shear, and the pressure in gaps; no contacts";

/// Signals of each wall and symmetry plane of the domain, named `x_lower.value`; of its force [N].
pub const OF_WALLS: [SignalRow<[f64; 3]>; 3] = [
    ("wall_force_x", "N", WALL, |force| force[0]),
    ("wall_force_y", "N", WALL, |force| force[1]),
    ("wall_force_z", "N", WALL, |force| force[2]),
];

/// Signals of each part, named `part.value`.
pub const OF_PARTS: [SignalRow<Load>; 6] = [
    ("force_x", "N", FORCE, |load| load.force[0]),
    ("force_y", "N", FORCE, |load| load.force[1]),
    ("force_z", "N", FORCE, |load| load.force[2]),
    ("torque_x", "N m", TORQUE, |load| load.torque[0]),
    ("torque_y", "N m", TORQUE, |load| load.torque[1]),
    ("torque_z", "N m", TORQUE, |load| load.torque[2]),
];

/// Axis and side of the faces on which the fluid acts: walls and symmetry planes.
pub fn walls(scene: &Scene) -> impl Iterator<Item = (usize, usize)> {
    let all = (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]);
    all.filter(|&(axis, side)| {
        matches!(scene.domain.faces[axis][side], Face::Wall { .. } | Face::Symmetry)
    })
}
