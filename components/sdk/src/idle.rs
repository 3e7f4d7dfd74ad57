//! Idle components, which compute nothing: a run of them measures the exchange alone.

use crate::line::ControlPipe;
use crate::roles::{Fluid, Grains, SolverError};
use crate::setup::Setup;
use crate::{AsFluid, AsGrains};
use std::collections::BTreeMap;
use tremie_messages::start::Description;
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_state::{StateError, StateExchange};

/// Length of a window [s]; it has no physical meaning here.
pub const WINDOW: f64 = 1e-6;

/// A fluid that finds no loads.
struct IdleFluid;

impl Fluid for IdleFluid {
    const PROGRAM: &'static str = "idle-fluid";

    fn describe(_: &Setup) -> Result<Description, Vec<Problem>> {
        Ok(Description { state: Some(1), ..Description::default() })
    }

    fn create(_: &Setup) -> Result<Self, Vec<Problem>> {
        Ok(Self)
    }

    fn events(&mut self, _: &[BodyEvent]) -> Result<(), SolverError> {
        Ok(())
    }

    fn start(&mut self, _: &[BodyState], _: &mut [Load]) -> Result<(), SolverError> {
        Ok(())
    }

    fn advance(&mut self, _: u32, _: &[BodyState], _: &mut [Load]) -> Result<(), SolverError> {
        // The loads are zero already.
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("nothing", &mut ())
    }

    fn signals(&mut self, _: &mut Vec<f64>) {}
}

/// Grains that never move.
struct IdleGrains {
    count: usize,
    /// The initial bodies until the first window is over.
    events: Vec<BodyEvent>,
}

/// The number of bodies that the settings ask for.
fn count(setup: &Setup) -> Result<usize, Vec<Problem>> {
    let parameters: BTreeMap<String, usize> = setup.parameters()?;
    parameters.get("bodies").copied().ok_or_else(|| vec![Problem::new("bodies", "is missing")])
}

impl Grains for IdleGrains {
    const PROGRAM: &'static str = "idle-grains";

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let bodies = count(setup)? as u64;
        Ok(Description { step: Some(WINDOW), bodies, state: Some(1), ..Description::default() })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let count = count(setup)?;
        let added = |id| BodyEvent {
            id,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::SPHERE,
            motion: BodyEvent::FREE,
            set: 0,
            mass: 1.0,
            size: [1e-3, 0.0, 0.0],
            table: 0,
        };
        Ok(Self { count, events: (0..count as u64).map(added).collect() })
    }

    fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    fn count(&self) -> usize {
        self.count
    }

    fn state(&self, bodies: &mut [BodyState]) {
        for (id, body) in bodies.iter_mut().enumerate() {
            *body = BodyState::at_rest(id as u64, [0.0; 3]);
        }
    }

    fn advance(&mut self, _: u32, _: &[Load]) -> Result<(), SolverError> {
        self.events.clear();
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("events", &mut self.events)
    }

    fn signals(&mut self, _: &mut Vec<f64>) {}
}

/// Takes part in a run as a fluid that finds no loads.
///
/// # Errors
/// A sentence for standard error.
pub fn run_fluid(line: ControlPipe) -> Result<(), String> {
    crate::run::<AsFluid<IdleFluid>>(line)
}

/// Takes part in a run as grains that never move.
///
/// # Errors
/// A sentence for standard error.
pub fn run_grains(line: ControlPipe) -> Result<(), String> {
    crate::run::<AsGrains<IdleGrains>>(line)
}
