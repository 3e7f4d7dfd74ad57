//! The signals of the grains: name, unit, meaning and value of each, in one table for each kind of
//! thing that has them.

use crate::bodies::drag_bands::DragBandState;
use crate::bodies::slider::SliderState;
use crate::grains::findings::MAX_OVERLAP;
use crate::solver::diagnostics::Diagnostics;
use crate::solver::ports::{InletState, OutletState};
use tremie_messages::start::SignalRow;

/// Force of the grains on a part, and torque about its reference point.
pub(crate) type PartLoads = ([f64; 3], [f64; 3]);

const MEAN: &str = "mean coordinate of the centres of all free bodies";
const FORCE: &str = "force of the grains on the part, fixed or moving: contacts and lubrication at the end of \
    the window; no fluid, no stops";
const WALL: &str = "force of the grains on this face of the domain at the end of the window: contacts and lubrication; no fluid";
const REMOVED: &str = "momentum that its drag took from the grains since the start";

/// Signals of all bodies together.
pub(crate) const OF_ALL: &[SignalRow<Diagnostics>] = &[
    ("max_speed", "m/s", "largest speed of a free body or a slider", |d| d.max_speed),
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
    ("elastic_energy", "J", "energy in the springs of contacts, sliders and stops", |d| {
        d.elastic_energy
    }),
    ("momentum_x", "kg m/s", "momentum of all free bodies and sliders", |d| d.momentum[0]),
    ("momentum_y", "kg m/s", "momentum of all free bodies and sliders", |d| d.momentum[1]),
    ("momentum_z", "kg m/s", "momentum of all free bodies and sliders", |d| d.momentum[2]),
    (
        "contacts",
        "1",
        "contacts at the end of the window: between bodies, and of bodies with walls and parts",
        |d| d.contacts as f64,
    ),
    (
        MAX_OVERLAP,
        "1",
        "largest overlap since the start over the smaller radius of its pair",
        |d| d.max_overlap_ratio,
    ),
    ("list_rebuilds", "1", "neighbour lists made since the start", |d| d.list_rebuilds as f64),
    ("mean_x", "m", MEAN, |d| d.mean_place[0]),
    ("mean_y", "m", MEAN, |d| d.mean_place[1]),
    ("mean_z", "m", MEAN, |d| d.mean_place[2]),
];

/// Signals of each face of the domain that holds grains, named `x_lower.value`.
pub(crate) const FACE: &[SignalRow<[f64; 3]>] = &[
    ("wall_force_x", "N", WALL, |f| f[0]),
    ("wall_force_y", "N", WALL, |f| f[1]),
    ("wall_force_z", "N", WALL, |f| f[2]),
];

/// Signals of each part: force of the grains, and torque about its reference point.
pub(crate) const PART: &[SignalRow<PartLoads>] = &[
    ("force_x", "N", FORCE, |l| l.0[0]),
    ("force_y", "N", FORCE, |l| l.0[1]),
    ("force_z", "N", FORCE, |l| l.0[2]),
    ("torque_x", "N m", "torque of the same about the origin of the part's frame", |l| l.1[0]),
    ("torque_y", "N m", "torque of the same about the origin of the part's frame", |l| l.1[1]),
    ("torque_z", "N m", "torque of the same about the origin of the part's frame", |l| l.1[2]),
];

/// Signals of each slider: forces are along its axis, on the whole part. Those of the deformable
/// surfaces that it carries are by themselves: of contacts, and of other forces on them.
pub(crate) const SLIDER: &[SignalRow<SliderState>] = &[
    ("lift", "m", "travel of the part along its axis", |s| s.lift),
    ("velocity", "m/s", "velocity of the part along its axis", |s| s.velocity),
    ("spring_force", "N", "force of the spring along the axis, negative while it closes", |s| {
        s.spring_force
    }),
    (
        "contact_force",
        "N",
        "force of the grains along the axis at the end of the window: contacts and lubrication; no fluid, no stops",
        |s| s.contact_force,
    ),
    ("stop_force", "N", "force of the stops along the axis, positive from the lower one", |s| {
        s.stop_force
    }),
    (
        "fluid_force",
        "N",
        "force of the fluid along the axis under which it went through the window, all that fluid.PART.force_x to z hold: buoyancy too",
        |s| s.fluid_force,
    ),
    (
        "surface_force",
        "N",
        "force of contacts on the surfaces that the part carries, along the axis",
        |s| s.surface_force,
    ),
    ("carrier_force", "N", "what else acts on these surfaces along the axis: a fluid", |s| {
        s.carrier_force
    }),
];

/// Signals of each inlet, since the start.
pub(crate) const INLET: &[SignalRow<InletState>] = &[
    ("inserted", "1", "grains that came since the start", |i| i.inserted as f64),
    (
        "deficit",
        "m3",
        "volume that is still to come to reach the fraction; 0 where less than half a sphere lacks",
        |i| i.deficit,
    ),
    ("mass_inserted", "kg", "mass of grains that came since the start", |i| i.mass_inserted),
];

/// Signals of each outlet, since the start.
pub(crate) const OUTLET: &[SignalRow<OutletState>] = &[
    ("removed", "1", "grains that went since the start", |o| o.removed as f64),
    ("mass_removed", "kg", "mass of grains that went since the start", |o| o.mass_removed),
];

/// Signals of each drag band, since the start.
pub(crate) const DRAG_BAND: &[SignalRow<DragBandState>] = &[
    ("momentum_removed_x", "kg m/s", REMOVED, |b| b.momentum_removed[0]),
    ("momentum_removed_y", "kg m/s", REMOVED, |b| b.momentum_removed[1]),
    ("momentum_removed_z", "kg m/s", REMOVED, |b| b.momentum_removed[2]),
    ("energy_removed", "J", "energy that its drag took from the grains since the start", |b| {
        b.energy_removed
    }),
];

/// Signal of the number of grains, in runs where they come and go.
pub(crate) const BODIES: &[SignalRow<usize>] =
    &[("bodies", "1", "grains that are there", |n| *n as f64)];
