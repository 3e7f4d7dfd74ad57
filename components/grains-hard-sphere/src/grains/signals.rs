//! Names, units, meanings and values of the signals of hard spheres.

use crate::Vec3;
use crate::solver::diagnostics::HardDiagnostics;
use tremie_messages::Load;
use tremie_messages::start::signal_row::SignalRow;

const MEAN: &str = "mean coordinate of the centres of all free bodies";
const FORCE: &str =
    "force of the grains on the part: the mean over the window of what collisions gave; no fluid";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the grains on this face of the domain: the mean over the window of what collisions gave; no fluid";
const GUARDED_TIME: &str = "collisions since the start that were elastic because a partner had collided less than contact_time before";
const GUARDED_SPEED: &str = "collisions since the start that were elastic because they were slower than elastic_speed, or than weight undoes in a step";

/// Signals of all bodies together.
pub const OF_ALL: &[SignalRow<HardDiagnostics>] = &[
    ("max_speed", "m/s", "largest speed of a free body", |d| d.max_speed),
    (
        "mean_height",
        "m",
        "mean height of centres against gravity, from the domain's lowest point; 0 without gravity",
        |d| d.mean_height,
    ),
    ("kinetic_energy", "J", "energy of translation", |d| d.kinetic_energy),
    ("rotational_energy", "J", "energy of rotation", |d| d.rotational_energy),
    ("potential_energy", "J", "energy of weight, from the domain's lowest point", |d| {
        d.potential_energy
    }),
    ("momentum_x", "kg m/s", "momentum of all free bodies", |d| d.momentum[0]),
    ("momentum_y", "kg m/s", "momentum of all free bodies", |d| d.momentum[1]),
    ("momentum_z", "kg m/s", "momentum of all free bodies", |d| d.momentum[2]),
    ("collisions", "1", "collisions of bodies with each other since the start", |d| {
        d.collisions as f64
    }),
    ("wall_collisions", "1", "collisions of bodies with walls and parts since the start", |d| {
        d.wall_collisions as f64
    }),
    ("guarded_by_time", "1", GUARDED_TIME, |d| d.guarded_by_time as f64),
    ("guarded_by_speed", "1", GUARDED_SPEED, |d| d.guarded_by_speed as f64),
    (
        "crowded",
        "1",
        "bodies, summed over steps, that collided more than most_collisions times in a step and stood still for its rest",
        |d| d.crowded as f64,
    ),
    ("mean_x", "m", MEAN, |d| d.mean_place[0]),
    ("mean_y", "m", MEAN, |d| d.mean_place[1]),
    ("mean_z", "m", MEAN, |d| d.mean_place[2]),
];

/// Signals of each face of the domain that holds grains, named `x_lower.value`.
pub const FACE: &[SignalRow<Vec3>] = &[
    ("wall_force_x", "N", WALL, |f| f.x),
    ("wall_force_y", "N", WALL, |f| f.y),
    ("wall_force_z", "N", WALL, |f| f.z),
];

/// Signals of each part.
pub const PART: &[SignalRow<Load>] = &[
    ("force_x", "N", FORCE, |l| l.force[0]),
    ("force_y", "N", FORCE, |l| l.force[1]),
    ("force_z", "N", FORCE, |l| l.force[2]),
    ("torque_x", "N m", TORQUE, |l| l.torque[0]),
    ("torque_y", "N m", TORQUE, |l| l.torque[1]),
    ("torque_z", "N m", TORQUE, |l| l.torque[2]),
];
