//! A class of Python as the fluid of a run.

use super::call::{call_lending, create, describe, failed, fill_frame, push_signals, says};
use super::{UNNAMED, program, state};
use crate::memory::Lent;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::start::Description;
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_sdk::state::{StateError, StateExchange};
use tremie_sdk::{Fluid, Setup, SolverError};

/// A fluid that a class of Python is.
pub struct PythonFluid {
    solver: Py<PyAny>,
    /// What went wrong in a frame, for the next window.
    lost_frame: Option<String>,
}

impl Fluid for PythonFluid {
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
        Ok(Self { solver: create(setup)?, lost_frame: None })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        // The list of most windows is empty.
        if events.is_empty() {
            return Ok(());
        }
        Python::attach(|py| {
            let events = lend(Lent::read(py, events))?;
            self.call(py, "events", Vec::new(), vec![("events", events)])
        })
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        Python::attach(|py| {
            let lent = both(py, bodies, loads)?;
            self.call(py, "start", Vec::new(), lent)
        })
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        self.lost_frame.take().map_or(Ok(()), |why| Err(failed(why)))?;
        Python::attach(|py| {
            let lent = both(py, bodies, loads)?;
            let substeps = substeps.into_pyobject(py).map(|number| number.into_any());
            let leading = substeps.map_err(|error| failed(error.to_string()))?;
            self.call(py, "advance", vec![leading], lent)
        })
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state::exchange(&self.solver, state)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        push_signals(&self.solver, "signals", values);
    }

    fn slice(&mut self, name: &str, nodes: &mut [SliceNode]) -> SliceHeader {
        let filled = Python::attach(|py| {
            let lent = Lent::write(py, nodes).map_err(|error| error.to_string())?;
            let name = pyo3::types::PyString::new(py, name).into_any();
            let header = fill_frame(self.solver.bind(py), "slice", vec![name], lent)?;
            header_of(&header).map_err(|error| format!("the header of slice: {error}"))
        });
        filled.unwrap_or_else(|why| {
            self.lost_frame = Some(why);
            SliceHeader::default()
        })
    }
}

impl PythonFluid {
    fn call<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        leading: Vec<Bound<'py, PyAny>>,
        lent: Vec<(&str, Lent<'py>)>,
    ) -> Result<(), SolverError> {
        call_lending(self.solver.bind(py), method, leading, lent).map(drop).map_err(failed)
    }
}

/// Bodies to read, and their loads to write.
fn both<'py>(
    py: Python<'py>,
    bodies: &[BodyState],
    loads: &mut [Load],
) -> Result<Vec<(&'static str, Lent<'py>)>, SolverError> {
    Ok(vec![("bodies", lend(Lent::read(py, bodies))?), ("loads", lend(Lent::write(py, loads))?)])
}

fn lend<'py>(lent: PyResult<Lent<'py>>) -> Result<Lent<'py>, SolverError> {
    lent.map_err(|error| failed(format!("NumPy cannot show the channel's memory: {error}")))
}

/// The grid of a cut, from a dictionary; the sdk sets the stamp.
fn header_of(header: &Bound<'_, PyDict>) -> PyResult<SliceHeader> {
    let item = |name: &str| {
        header
            .get_item(name)?
            .ok_or_else(|| pyo3::exceptions::PyKeyError::new_err(format!("`{name}` is missing")))
    };
    Ok(SliceHeader {
        origin: item("origin")?.extract()?,
        step: item("step")?.extract()?,
        count: item("count")?.extract()?,
        ..SliceHeader::default()
    })
}
