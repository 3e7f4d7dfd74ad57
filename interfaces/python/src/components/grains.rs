//! A class of Python as the grains of a run.

use super::call::{call_lending, create, describe, failed, push_signals, raised, says};
use super::{UNNAMED, program, state};
use crate::memory::Lent;
use pyo3::prelude::*;
use tremie_messages::start::Description;
use tremie_messages::{BodyEvent, BodyState, Load, Problem, bytes_of, values_of};
use tremie_sdk::state::{StateError, StateExchange};
use tremie_sdk::{Grains, Setup, SolverError};

/// Grains that a class of Python is.
pub struct PythonGrains {
    solver: Py<PyAny>,
    /// Bodies that appeared or disappeared at the last window's end.
    events: Vec<BodyEvent>,
    /// Living bodies.
    count: usize,
}

impl Grains for PythonGrains {
    const PROGRAM: &'static str = UNNAMED;

    fn program() -> String {
        program()
    }

    fn takes_polyhedra() -> bool {
        says("takes_polyhedra")
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        describe(setup)
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let mut grains = Self { solver: create(setup)?, events: Vec::new(), count: 0 };
        grains.ask_events().map_err(|error| vec![Problem::new("", error.to_string())])?;
        Ok(grains)
    }

    fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    fn count(&self) -> usize {
        self.count
    }

    fn state(&self, bodies: &mut [BodyState]) {
        let written = Python::attach(|py| {
            let lent = Lent::write(py, bodies).map_err(|error| error.to_string())?;
            call_lending(self.solver.bind(py), "state", Vec::new(), vec![("bodies", lent)])
                .map(drop)
        });
        // As with signals: the sdk takes a panic's text as the component's failure.
        written.unwrap_or_else(|why: String| std::panic::resume_unwind(Box::new(why)));
    }

    fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError> {
        Python::attach(|py| {
            let lent = Lent::read(py, loads);
            let lent = lent.map_err(|error| failed(error.to_string()))?;
            let substeps = substeps.into_pyobject(py).map(|number| number.into_any());
            let leading = substeps.map_err(|error| failed(error.to_string()))?;
            call_lending(self.solver.bind(py), "advance", vec![leading], vec![("loads", lent)])
                .map(drop)
                .map_err(failed)
        })?;
        self.ask_events()
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let mut events = bytes_of(&self.events).to_vec();
        state.value("count", &mut self.count)?;
        state.list("events", &mut events)?;
        if state.restores() {
            let read = values_of(&events);
            self.events = read.ok_or_else(|| StateError::Unfit("half an event".into()))?;
        }
        state::exchange(&self.solver, state)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        push_signals(&self.solver, "signals", values);
    }
}

impl PythonGrains {
    /// Takes the events of the window that has ended, and counts who lives.
    fn ask_events(&mut self) -> Result<(), SolverError> {
        self.events = Python::attach(|py| {
            let asked = || -> PyResult<Option<Vec<BodyEvent>>> {
                let found = self.solver.bind(py).call_method0("_events")?;
                Ok(values_of(&found.extract::<Vec<u8>>()?))
            };
            let found = asked().map_err(|error| failed(raised(py, "events", &error)))?;
            found.ok_or_else(|| failed("events gave half an event".into()))
        })?;
        for event in &self.events {
            match event.kind {
                BodyEvent::ADDED => self.count += 1,
                _ => self.count = self.count.saturating_sub(1),
            }
        }
        Ok(())
    }
}
