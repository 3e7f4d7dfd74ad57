//! Signals of the fluid: name, unit, meaning and value of each, in the order in which they are
//! told.

use crate::fluid::pic_fluid::FluidState;
use crate::pressure::conjugate_gradients::PressureOutcome;
use tremie_fluid_kit::probes::probe_signals::describe_probes;
use tremie_fluid_kit::window::fluid_signals::{describe_loads, part_rows, wall_rows};
use tremie_sdk::messages::Load;
use tremie_sdk::messages::scene::Scene;
use tremie_sdk::messages::start::Signal;
use tremie_sdk::messages::start::signal_row::{SignalRow, describe};

const MOMENTUM: &str = "momentum of the fluid";
const FARTHEST: &str = "farthest coordinate of a particle along the axis: the front, or the crest";
const ON_BODIES: &str = "force of the fluid on all bodies together: pressure and shear";
const GAP_DAMPING: &str = "force by which the damping in gaps slows the fluid; nothing gets it";
const SHEAR: &str = "force of shear alone on all bodies together";

impl FluidState {
    fn iteration(&self, of: impl Fn(&PressureOutcome) -> f64) -> f64 {
        self.outcome.as_ref().map_or(0.0, of)
    }
}

/// Signals of the whole fluid.
pub const OF_FLUID: [SignalRow<FluidState>; 29] = [
    ("max_speed", "m/s", "largest speed of a particle", |s| s.sums.max_speed),
    ("courant", "1", "cells that it crosses in a step", |s| s.courant),
    ("volume", "m³", "volume of the fluid", |s| s.sums.volume),
    (
        "volume_drift",
        "1",
        "size of its change since the start, less what passed open faces, over that at the start and what entered: the method's error",
        |s| {
            let [entered, left] = s.passed;
            let change = s.sums.volume - s.first_volume - entered + left;
            (change / (s.first_volume + entered)).abs()
        },
    ),
    ("volume_entered", "m³", "volume that entered through open faces", |s| s.passed[0]),
    ("volume_left", "m³", "volume that left through them", |s| s.passed[1]),
    ("kinetic_energy", "J", "kinetic energy of the particles", |s| s.sums.kinetic),
    (
        "potential_energy",
        "J",
        "potential energy of the particles in gravity, from the domain's lower corner",
        |s| s.sums.potential,
    ),
    ("momentum_x", "kg m/s", MOMENTUM, |s| s.sums.momentum[0]),
    ("momentum_y", "kg m/s", MOMENTUM, |s| s.sums.momentum[1]),
    ("momentum_z", "kg m/s", MOMENTUM, |s| s.sums.momentum[2]),
    ("farthest_x", "m", FARTHEST, |s| s.sums.farthest[0]),
    ("farthest_y", "m", FARTHEST, |s| s.sums.farthest[1]),
    ("farthest_z", "m", FARTHEST, |s| s.sums.farthest[2]),
    ("body_force_x", "N", ON_BODIES, |s| s.on_bodies[0][0]),
    ("body_force_y", "N", ON_BODIES, |s| s.on_bodies[0][1]),
    ("body_force_z", "N", ON_BODIES, |s| s.on_bodies[0][2]),
    ("body_shear_x", "N", SHEAR, |s| s.on_bodies[1][0]),
    ("body_shear_y", "N", SHEAR, |s| s.on_bodies[1][1]),
    ("body_shear_z", "N", SHEAR, |s| s.on_bodies[1][2]),
    ("gap_damping_x", "N", GAP_DAMPING, |s| s.gap_damping[0]),
    ("gap_damping_y", "N", GAP_DAMPING, |s| s.gap_damping[1]),
    ("gap_damping_z", "N", GAP_DAMPING, |s| s.gap_damping[2]),
    ("wet_cells", "1", "cells that are part of the fluid", |s| s.wet_cells as f64),
    ("particles", "1", "particles", |s| s.particles as f64),
    ("iterations", "1", "iterations of the pressure in the last step", |s| {
        s.iteration(|outcome| outcome.iterations as f64)
    }),
    (
        "imbalance",
        "m/s",
        "largest imbalance of a cell's volume that they left, as the sum of velocities times open parts of faces",
        |s| s.iteration(|outcome| outcome.residual),
    ),
    (
        "divergence",
        "1/s",
        "the same, found anew from the velocities, over the edge of a cell",
        |s| s.divergence,
    ),
    ("particles_per_cell", "1", "particles over wet cells", |s| {
        s.particles as f64 / s.wet_cells.max(1) as f64
    }),
];

const FORCE: &str =
    "force of the fluid on the part: pressure with its hydrostatic part, and shear; no contacts";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the fluid on this face of the domain: pressure with its hydrostatic part, and shear; no contacts";

/// Signals of each wall and symmetry plane of the domain, named `x_lower.value`; of its force [N].
pub const OF_WALLS: [SignalRow<[f64; 3]>; 3] = wall_rows(WALL);

/// Signals of each part, named `part.value`.
pub const OF_PARTS: [SignalRow<Load>; 6] = part_rows(FORCE, TORQUE);

/// All signals of a scene, in the order in which they are told.
pub fn signals(scene: &Scene) -> Vec<Signal> {
    let mut all: Vec<_> = describe(&OF_FLUID, "").collect();
    all.extend(describe_loads(scene, &OF_WALLS, &OF_PARTS));
    all.extend(describe_probes(scene));
    all
}
