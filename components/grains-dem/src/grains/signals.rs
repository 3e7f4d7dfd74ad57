//! The signals of the grains: name, unit, meaning and value of each, in one table for each kind of
//! thing that has them.

use crate::bodies::slider::SliderState;
use crate::solver::diagnostics::Diagnostics;
use crate::solver::ports::{InletState, OutletState};
use tremie_messages::start::Signal;
use tremie_messages::{BodyState, Load};

/// A signal of a `T`.
pub(crate) struct SignalOf<T> {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    value: fn(&T) -> f64,
}

impl<T> SignalOf<T> {
    const fn new(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        value: fn(&T) -> f64,
    ) -> Self {
        Self { name, unit, meaning, value }
    }
}

/// Describes the signals of a table; each is named by what stands before its name.
pub(crate) fn describe<T>(table: &[SignalOf<T>], before: &str) -> impl Iterator<Item = Signal> {
    table.iter().map(move |own| Signal {
        name: format!("{before}{}", own.name),
        unit: own.unit.into(),
        meaning: own.meaning.into(),
        sampled: false,
    })
}

/// Pushes the values of a table, in its order.
pub(crate) fn push<T>(table: &[SignalOf<T>], of: &T, values: &mut Vec<f64>) {
    values.extend(table.iter().map(|own| (own.value)(of)));
}

/// Force of the grains on a part, and torque about its reference point.
pub(crate) type PartLoads = ([f64; 3], [f64; 3]);

const PLACE: &str =
    "position of a body's centre, a clump's centroid, or the origin of a part's frame";
const TURN: &str = "its orientation, a unit quaternion (x, y, z, w) from its frame to the world";
const FORCE: &str = "force of the grains on the part, fixed or moving: contacts and lubrication at the end of \
    the window; no fluid, no stops";
const WALL: &str = "force of the grains on this face of the domain at the end of the window: contacts and lubrication; no fluid";
const FLUID_FORCE: &str = "force of the fluid under which it went through the window: gauge pressure, shear, the pressure \
    in gaps, and buoyancy; no contacts";
const FLUID_TORQUE: &str = "torque of the same about the body's centre or the clump's centroid";

/// Signals of all bodies together.
pub(crate) const OF_ALL: &[SignalOf<Diagnostics>] = &[
    SignalOf::new("max_speed", "m/s", "largest speed of a free body or a slider", |d| d.max_speed),
    SignalOf::new(
        "mean_height",
        "m",
        "mean height of centres against gravity, from the domain's lowest point; 0 without gravity",
        |d| d.mean_height,
    ),
    SignalOf::new("kinetic_energy", "J", "energy of translation", |d| d.kinetic_energy),
    SignalOf::new("rotational_energy", "J", "energy of rotation", |d| d.rotational_energy),
    SignalOf::new(
        "potential_energy",
        "J",
        "energy of weight, from the domain's lowest point",
        |d| d.potential_energy,
    ),
    SignalOf::new(
        "elastic_energy",
        "J",
        "energy in the springs of contacts, sliders and stops",
        |d| d.elastic_energy,
    ),
    SignalOf::new("momentum_x", "kg m/s", "momentum of all free bodies and sliders", |d| {
        d.momentum[0]
    }),
    SignalOf::new("momentum_y", "kg m/s", "momentum of all free bodies and sliders", |d| {
        d.momentum[1]
    }),
    SignalOf::new("momentum_z", "kg m/s", "momentum of all free bodies and sliders", |d| {
        d.momentum[2]
    }),
    SignalOf::new(
        "contacts",
        "1",
        "contacts at the end of the window: between bodies, and of bodies with walls and parts",
        |d| d.contacts as f64,
    ),
    SignalOf::new(
        "max_overlap_ratio",
        "1",
        "largest overlap since the start over the smaller radius of its pair",
        |d| d.max_overlap_ratio,
    ),
    SignalOf::new("list_rebuilds", "1", "neighbour lists made since the start", |d| {
        d.list_rebuilds as f64
    }),
];

/// Signals of each sphere, where they are few.
pub(crate) const PATH: &[SignalOf<BodyState>] = &[
    SignalOf::new("x", "m", PLACE, |b| b.position[0]),
    SignalOf::new("y", "m", PLACE, |b| b.position[1]),
    SignalOf::new("z", "m", PLACE, |b| b.position[2]),
    SignalOf::new("vx", "m/s", "its velocity", |b| b.velocity[0]),
    SignalOf::new("vy", "m/s", "its velocity", |b| b.velocity[1]),
    SignalOf::new("vz", "m/s", "its velocity", |b| b.velocity[2]),
];

/// Signals of the motion of each followed body, clump and moving part.
pub(crate) const MOTION: &[SignalOf<BodyState>] = &[
    SignalOf::new("x", "m", PLACE, |b| b.position[0]),
    SignalOf::new("y", "m", PLACE, |b| b.position[1]),
    SignalOf::new("z", "m", PLACE, |b| b.position[2]),
    SignalOf::new("qx", "1", TURN, |b| b.orientation[0]),
    SignalOf::new("qy", "1", TURN, |b| b.orientation[1]),
    SignalOf::new("qz", "1", TURN, |b| b.orientation[2]),
    SignalOf::new("qw", "1", TURN, |b| b.orientation[3]),
    SignalOf::new("vx", "m/s", "its velocity", |b| b.velocity[0]),
    SignalOf::new("vy", "m/s", "its velocity", |b| b.velocity[1]),
    SignalOf::new("vz", "m/s", "its velocity", |b| b.velocity[2]),
    SignalOf::new("wx", "rad/s", "its angular velocity", |b| b.angular_velocity[0]),
    SignalOf::new("wy", "rad/s", "its angular velocity", |b| b.angular_velocity[1]),
    SignalOf::new("wz", "rad/s", "its angular velocity", |b| b.angular_velocity[2]),
];

/// Signals of the fluid on each followed body and clump; of parts the fluid itself tells.
pub(crate) const FLUID: &[SignalOf<Load>] = &[
    SignalOf::new("fluid_force_x", "N", FLUID_FORCE, |l| l.force[0]),
    SignalOf::new("fluid_force_y", "N", FLUID_FORCE, |l| l.force[1]),
    SignalOf::new("fluid_force_z", "N", FLUID_FORCE, |l| l.force[2]),
    SignalOf::new("fluid_torque_x", "N m", FLUID_TORQUE, |l| l.torque[0]),
    SignalOf::new("fluid_torque_y", "N m", FLUID_TORQUE, |l| l.torque[1]),
    SignalOf::new("fluid_torque_z", "N m", FLUID_TORQUE, |l| l.torque[2]),
];

/// Signals of each face of the domain that holds grains, named `x_lower.value`.
pub(crate) const FACE: &[SignalOf<[f64; 3]>] = &[
    SignalOf::new("wall_force_x", "N", WALL, |f| f[0]),
    SignalOf::new("wall_force_y", "N", WALL, |f| f[1]),
    SignalOf::new("wall_force_z", "N", WALL, |f| f[2]),
];

/// Signals of each part: force of the grains, and torque about its reference point.
pub(crate) const PART: &[SignalOf<PartLoads>] = &[
    SignalOf::new("force_x", "N", FORCE, |l| l.0[0]),
    SignalOf::new("force_y", "N", FORCE, |l| l.0[1]),
    SignalOf::new("force_z", "N", FORCE, |l| l.0[2]),
    SignalOf::new(
        "torque_x",
        "N m",
        "torque of the same about the origin of the part's frame",
        |l| l.1[0],
    ),
    SignalOf::new(
        "torque_y",
        "N m",
        "torque of the same about the origin of the part's frame",
        |l| l.1[1],
    ),
    SignalOf::new(
        "torque_z",
        "N m",
        "torque of the same about the origin of the part's frame",
        |l| l.1[2],
    ),
];

/// Signals of each slider: forces are along its axis, on the whole part. Those of the deformable
/// surfaces that it carries are by themselves: of contacts, and of other forces on them.
pub(crate) const SLIDER: &[SignalOf<SliderState>] = &[
    SignalOf::new("lift", "m", "travel of the part along its axis", |s| s.lift),
    SignalOf::new("velocity", "m/s", "velocity of the part along its axis", |s| s.velocity),
    SignalOf::new(
        "spring_force",
        "N",
        "force of the spring along the axis, negative while it closes",
        |s| s.spring_force,
    ),
    SignalOf::new(
        "contact_force",
        "N",
        "force of the grains along the axis at the end of the window: contacts and lubrication; no fluid, no stops",
        |s| s.contact_force,
    ),
    SignalOf::new(
        "stop_force",
        "N",
        "force of the stops along the axis, positive from the lower one",
        |s| s.stop_force,
    ),
    SignalOf::new(
        "fluid_force",
        "N",
        "force of the fluid along the axis under which it went through the window, all that fluid.PART.force_x to z hold: buoyancy too",
        |s| s.fluid_force,
    ),
    SignalOf::new(
        "surface_force",
        "N",
        "force of contacts on the surfaces that the part carries, along the axis",
        |s| s.surface_force,
    ),
    SignalOf::new(
        "carrier_force",
        "N",
        "what else acts on these surfaces along the axis: a fluid",
        |s| s.carrier_force,
    ),
];

/// Signals of each inlet, since the start.
pub(crate) const INLET: &[SignalOf<InletState>] = &[
    SignalOf::new("inserted", "1", "grains that came since the start", |i| i.inserted as f64),
    SignalOf::new(
        "deficit",
        "m3",
        "volume that is still to come to reach the fraction; 0 where less than half a sphere lacks",
        |i| i.deficit,
    ),
    SignalOf::new("mass_inserted", "kg", "mass of grains that came since the start", |i| {
        i.mass_inserted
    }),
];

/// Signals of each outlet, since the start.
pub(crate) const OUTLET: &[SignalOf<OutletState>] = &[
    SignalOf::new("removed", "1", "grains that went since the start", |o| o.removed as f64),
    SignalOf::new("mass_removed", "kg", "mass of grains that went since the start", |o| {
        o.mass_removed
    }),
];

/// Signal of the number of grains, in runs where they come and go.
pub(crate) const BODIES: &[SignalOf<usize>] =
    &[SignalOf::new("bodies", "1", "grains that are there", |n| *n as f64)];
