//! Signals of the gas: name, unit, meaning and value of each, in the order in which they are told.

use crate::fluid::gas_fluid::GasFluidState;
use tremie_fluid_kit::probes::probe_signals::describe_probes;
use tremie_fluid_kit::window::fluid_signals::{describe_loads, part_rows, wall_rows};
use tremie_sdk::messages::Load;
use tremie_sdk::messages::scene::Scene;
use tremie_sdk::messages::start::Signal;
use tremie_sdk::messages::start::signal_row::{SignalRow, describe};

const MOMENTUM: &str = "momentum of the gas";
const BY_STRESS: &str = "force of the gas on all moving bodies together, by the stress at their surfaces; a mean over the window";
const BY_MOMENTUM: &str =
    "the same by the momentum that goes from points in the gas to points in the bodies";

impl GasFluidState {
    /// Change of a sum since the start over its size then.
    fn drift(&self, of: usize) -> f64 {
        let (now, first) = (self.sums.fields[of], self.first.fields[of]);
        if self.is_closed { (now / first - 1.0).abs() } else { 0.0 }
    }
}

/// Signals of the whole gas.
pub const OF_GAS: [SignalRow<GasFluidState>; 26] = [
    ("max_speed", "m/s", "largest speed of the gas", |s| s.sums.max_speed),
    ("max_mach", "1", "largest Mach number of the gas", |s| s.sums.max_mach),
    ("least_density", "kg/m³", "least density of the gas", |s| s.sums.density[0]),
    ("greatest_density", "kg/m³", "greatest density of the gas", |s| s.sums.density[1]),
    (
        "density_deviation",
        "1",
        "how far densities have left the range that they had at the start: the greatest over that then, or the least then over the least, less 1",
        |s| s.sums.density_deviation(&s.first),
    ),
    ("least_pressure", "Pa", "least absolute pressure", |s| s.sums.pressure[0]),
    ("greatest_pressure", "Pa", "greatest absolute pressure", |s| s.sums.pressure[1]),
    ("mass", "kg", "mass of the gas", |s| s.depth * s.sums.fields[0]),
    (
        "mass_drift",
        "1",
        "size of its change since the start, over that at the start, where no face is open; else 0: what the method makes or loses, also at moving surfaces",
        |s| s.drift(0),
    ),
    ("energy", "J", "energy of heat and motion of the gas", |s| s.depth * s.energy()),
    (
        "energy_drift",
        "1",
        "size of its change since the start, over that at the start, where no face is open; else 0: what bodies and moving walls gave or took, and the method's error",
        |s| s.drift(s.energy_field),
    ),
    ("momentum_x", "kg m/s", MOMENTUM, |s| s.momentum[0]),
    ("momentum_y", "kg m/s", MOMENTUM, |s| s.momentum[1]),
    ("momentum_z", "kg m/s", MOMENTUM, |s| s.momentum[2]),
    ("body_force_x", "N", BY_STRESS, |s| s.on_bodies[0][0]),
    ("body_force_y", "N", BY_STRESS, |s| s.on_bodies[0][1]),
    ("body_force_z", "N", BY_STRESS, |s| s.on_bodies[0][2]),
    ("body_momentum_x", "N", BY_MOMENTUM, |s| s.on_bodies[1][0]),
    ("body_momentum_y", "N", BY_MOMENTUM, |s| s.on_bodies[1][1]),
    ("body_momentum_z", "N", BY_MOMENTUM, |s| s.on_bodies[1][2]),
    ("points", "1", "points that are kept", |s| s.points[0]),
    (
        "significant_points",
        "1",
        "points whose detail exceeded the tolerance at the last adaptation; the others stand around them and around surfaces",
        |s| s.points[1],
    ),
    ("share_of_points", "1", "points that are kept over those of the finest grid", |s| s.points[2]),
    ("levels", "1", "levels that have points", |s| s.levels as f64),
    ("steps", "1", "steps of the gas in the window", |s| f64::from(s.steps)),
    ("blocks", "1", "blocks of points, coarser ones included", |s| s.blocks as f64),
];

const FORCE: &str = "force of the gas on the part: pressure from that at rest, and shear; no contacts; a mean over the window";
const TORQUE: &str = "torque of the same about the origin of the part's frame";
const WALL: &str = "force of the gas on this face of the domain: pressure from that at rest, and shear; no contacts";

/// Signals of each wall and symmetry plane of the domain, named `x_lower.value`; of its force [N].
pub const OF_WALLS: [SignalRow<[f64; 3]>; 3] = wall_rows(WALL);

/// Signals of each part, named `part.value`.
pub const OF_PARTS: [SignalRow<Load>; 6] = part_rows(FORCE, TORQUE);

/// All signals of a scene, in the order in which they are told.
pub fn signals(scene: &Scene) -> Vec<Signal> {
    let mut all: Vec<_> = describe(&OF_GAS, "").collect();
    all.extend(describe_loads(scene, &OF_WALLS, &OF_PARTS));
    all.extend(describe_probes(scene));
    all
}
