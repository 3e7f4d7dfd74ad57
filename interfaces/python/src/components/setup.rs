//! The run as a class of Python knows it.

use crate::documents::to_python;
use pyo3::prelude::*;
use tremie_sdk::Setup;

/// `tremie.Setup` of a hello and an assignment.
pub fn setup_of<'py>(py: Python<'py>, setup: &Setup) -> PyResult<Bound<'py, PyAny>> {
    let hello = to_python(py, &setup.hello)?;
    let assignment = match &setup.assignment {
        Some(assignment) => to_python(py, assignment)?,
        None => py.None().into_bound(py),
    };
    py.import("tremie")?.getattr("Setup")?.call1((hello, assignment, setup.goes_on()))
}
