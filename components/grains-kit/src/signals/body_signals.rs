//! Signals of the motion of one body, and of the fluid on it.

use tremie_messages::start::signal_row::SignalRow;
use tremie_messages::{BodyState, Load};

const PLACE: &str =
    "position of a body's centre, a clump's centroid, or the origin of a part's frame";
const TURN: &str = "its orientation, a unit quaternion (x, y, z, w) from its frame to the world";
const FLUID_FORCE: &str = "force of the fluid under which it went through the window: gauge pressure, shear, the pressure \
    in gaps, and buoyancy; no contacts";
const FLUID_TORQUE: &str = "torque of the same about the body's centre or the clump's centroid";

/// Signals of each sphere, where they are few.
pub const PATH: &[SignalRow<BodyState>] = &[
    ("x", "m", PLACE, |b| b.position[0]),
    ("y", "m", PLACE, |b| b.position[1]),
    ("z", "m", PLACE, |b| b.position[2]),
    ("vx", "m/s", "its velocity", |b| b.velocity[0]),
    ("vy", "m/s", "its velocity", |b| b.velocity[1]),
    ("vz", "m/s", "its velocity", |b| b.velocity[2]),
];

/// Signals of the motion of each followed body, clump and moving part.
pub const MOTION: &[SignalRow<BodyState>] = &[
    ("x", "m", PLACE, |b| b.position[0]),
    ("y", "m", PLACE, |b| b.position[1]),
    ("z", "m", PLACE, |b| b.position[2]),
    ("qx", "1", TURN, |b| b.orientation[0]),
    ("qy", "1", TURN, |b| b.orientation[1]),
    ("qz", "1", TURN, |b| b.orientation[2]),
    ("qw", "1", TURN, |b| b.orientation[3]),
    ("vx", "m/s", "its velocity", |b| b.velocity[0]),
    ("vy", "m/s", "its velocity", |b| b.velocity[1]),
    ("vz", "m/s", "its velocity", |b| b.velocity[2]),
    ("wx", "rad/s", "its angular velocity", |b| b.angular_velocity[0]),
    ("wy", "rad/s", "its angular velocity", |b| b.angular_velocity[1]),
    ("wz", "rad/s", "its angular velocity", |b| b.angular_velocity[2]),
];

/// Signals of the fluid on each followed body and clump; of parts the fluid itself tells.
pub const FLUID: &[SignalRow<Load>] = &[
    ("fluid_force_x", "N", FLUID_FORCE, |l| l.force[0]),
    ("fluid_force_y", "N", FLUID_FORCE, |l| l.force[1]),
    ("fluid_force_z", "N", FLUID_FORCE, |l| l.force[2]),
    ("fluid_torque_x", "N m", FLUID_TORQUE, |l| l.torque[0]),
    ("fluid_torque_y", "N m", FLUID_TORQUE, |l| l.torque[1]),
    ("fluid_torque_z", "N m", FLUID_TORQUE, |l| l.torque[2]),
];
