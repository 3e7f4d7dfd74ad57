//! Signals of the fluid: name, unit, meaning and value of each, in the order in which they are
//! told.

use crate::boundary::virtual_piston::reservoir_state::{OF_RESERVOIRS, reservoirs_of};
use crate::lattice::ledger::Ledger;
use crate::solver::diagnostics::Diagnostics;
use tremie_fluid_kit::probes::probe_signals::describe_probes;
use tremie_fluid_kit::window::fluid_signals::{OF_PARTS, OF_WALLS, describe_loads};
use tremie_sdk::messages::scene::Scene;
use tremie_sdk::messages::start::Signal;
use tremie_sdk::messages::start::signal_row::{SignalRow, describe};

/// Sources of the signals of the whole fluid.
pub struct FluidState {
    /// Of the last step.
    pub diagnostics: Diagnostics,
    /// Balance of the last step.
    pub ledger: Ledger,
    /// Gauge pressure of a relative density deviation of one [Pa].
    pub stiffness: f64,
}

impl FluidState {
    /// Change of momentum that no listed term accounts for: rounding, if nothing is missing.
    fn momentum_residual(&self) -> f64 {
        let terms = self.ledger.momentum_terms();
        let change = self.ledger.momentum_change;
        (0..3).map(|k| (change[k] - terms[k]).abs()).fold(0.0, f64::max)
    }
}

const MOMENTUM: &str = "momentum of the fluid";
const WALL_IMPULSE: &str = "given to the fluid by the domain's walls in the last step";
const BODY_IMPULSE: &str = "given to the fluid by bodies in the last step";

/// Signals of the whole fluid.
pub const OF_FLUID: [SignalRow<FluidState>; 26] = [
    ("max_speed", "m/s", "largest speed of the fluid", |s| s.diagnostics.max_speed),
    ("max_mach", "1", "largest Mach number of the lattice", |s| s.diagnostics.max_mach),
    (
        "min_pressure",
        "Pa",
        "lowest gauge pressure without its hydrostatic part, 0 if all are above",
        |s| s.diagnostics.min_density_deviation * s.stiffness,
    ),
    (
        "max_pressure",
        "Pa",
        "highest gauge pressure without its hydrostatic part, 0 if all are below",
        |s| s.diagnostics.max_density_deviation * s.stiffness,
    ),
    (
        "max_density_deviation",
        "1",
        "largest size of the relative deviation of the density, without its hydrostatic part",
        |s| s.diagnostics.density_deviation(),
    ),
    ("links", "1", "lattice links from the fluid into bodies", |s| s.diagnostics.links as f64),
    (
        "fallback_links",
        "1",
        "of these, those without a second fluid cell: walls half-way there",
        |s| s.diagnostics.fallback_links as f64,
    ),
    ("isolated_cells", "1", "cells that are frozen because no neighbour is fluid", |s| {
        s.diagnostics.isolated as f64
    }),
    ("mass", "kg", "mass of the fluid", |s| s.ledger.mass),
    ("mass_change", "kg", "its change in the last step", |s| s.ledger.mass_change),
    ("mass_residual", "kg", "what of that no term of the balance accounts for: rounding", |s| {
        s.ledger.mass_change - s.ledger.mass_terms()
    }),
    ("momentum_x", "kg m/s", MOMENTUM, |s| s.ledger.momentum[0]),
    ("momentum_y", "kg m/s", MOMENTUM, |s| s.ledger.momentum[1]),
    ("momentum_z", "kg m/s", MOMENTUM, |s| s.ledger.momentum[2]),
    (
        "momentum_residual",
        "kg m/s",
        "largest part of its change that no term of the balance accounts for: rounding",
        FluidState::momentum_residual,
    ),
    ("wall_impulse_x", "kg m/s", WALL_IMPULSE, |s| s.ledger.walls[0]),
    ("wall_impulse_y", "kg m/s", WALL_IMPULSE, |s| s.ledger.walls[1]),
    ("wall_impulse_z", "kg m/s", WALL_IMPULSE, |s| s.ledger.walls[2]),
    ("body_impulse_x", "kg m/s", BODY_IMPULSE, |s| s.ledger.bodies[0]),
    ("body_impulse_y", "kg m/s", BODY_IMPULSE, |s| s.ledger.bodies[1]),
    ("body_impulse_z", "kg m/s", BODY_IMPULSE, |s| s.ledger.bodies[2]),
    ("max_relaxation_time", "1", "largest relaxation time, which a turbulence model raises", |s| {
        s.diagnostics.max_tau
    }),
    ("backflow_cells", "1", "cells at pressure faces through which fluid enters", |s| {
        s.diagnostics.entering as f64
    }),
    (
        "mass_owed",
        "kg",
        "what interpolated walls took, and moving bodies beyond their volume, and have not paid back",
        |s| s.ledger.mass_owed,
    ),
    (
        "mass_lost",
        "kg",
        "mass that links to walls and moving bodies took since the start, beyond what bodies displaced; negative: made",
        |s| s.ledger.mass_lost,
    ),
    ("mass_lost_share", "1", "its size over the mass of the fluid", |s| s.ledger.lost_share()),
];

/// All signals of a scene, in the order in which they are told.
pub fn signals(scene: &Scene) -> Vec<Signal> {
    let mut all: Vec<_> = describe(&OF_FLUID, "").collect();
    all.extend(describe_loads(scene, &OF_WALLS, &OF_PARTS));
    for (place, _) in reservoirs_of(scene) {
        let before = format!("reservoir_{}.", place.name(scene));
        all.extend(describe(&OF_RESERVOIRS, &before));
    }
    all.extend(describe_probes(scene));
    all
}
