//! Documents and quantities between the two languages.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde::Serialize;
use tremie_messages::units;

/// A document as Python has it: dictionaries, lists, texts and numbers.
pub fn to_python<'py>(py: Python<'py>, document: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(document)
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    py.import("json")?.call_method1("loads", (text,))
}

/// A document of Python as JSON.
pub fn to_json(document: &Bound<'_, PyAny>) -> PyResult<String> {
    document.py().import("json")?.call_method1("dumps", (document,))?.extract()
}

/// A text in TOML as a dictionary.
#[pyfunction]
pub fn read_toml<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: toml::Table =
        toml::from_str(text).map_err(|error| PyValueError::new_err(error.to_string()))?;
    to_python(py, &table)
}

/// Value in SI units of a quantity with its unit, as `quantity("0.3 mm", "length")`.
#[pyfunction]
pub fn quantity(text: &str, kind: &str) -> PyResult<f64> {
    let value = units::read(kind, text).ok_or_else(|| {
        let known = units::kinds().collect::<Vec<_>>().join(", ");
        let why = format!("there is no kind of quantity \"{kind}\"; there are {known}");
        PyValueError::new_err(why)
    })?;
    value.map_err(|error| PyValueError::new_err(error.to_string()))
}
