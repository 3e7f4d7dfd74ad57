//! States of classes of Python: a dictionary of arrays and of whatever JSON can hold.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::{Deserialize, Serialize};
use tremie_sdk::state::{StateError, StateExchange};

/// An array of a state: its name, NumPy's type and its lengths.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct KeptArray {
    name: String,
    dtype: String,
    shape: Vec<u64>,
}

/// What stands before the arrays.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Contents {
    /// Everything but the arrays, as JSON.
    document: String,
    arrays: Vec<KeptArray>,
}

/// Keeps what `save_state` gives, or hands it back to `restore_state`.
pub fn exchange(solver: &Py<PyAny>, state: &mut StateExchange<'_>) -> Result<(), StateError> {
    Python::attach(|py| {
        let solver = solver.bind(py);
        let unfit =
            |method: &str, error: PyErr| StateError::Unfit(super::call::raised(py, method, &error));
        if state.restores() {
            let given = restore(py, state)?;
            let put = given.and_then(|given| solver.call_method1("restore_state", (given,)));
            put.map(drop).map_err(|error| unfit("restore_state", error))
        } else {
            let saved = solver.call_method0("save_state").and_then(|saved| split(&saved));
            let (mut contents, mut bytes) = saved.map_err(|error| unfit("save_state", error))?;
            state.value("contents", &mut contents)?;
            for (array, bytes) in contents.arrays.iter().zip(&mut bytes) {
                state.list(&format!("array.{}", array.name), bytes)?;
            }
            Ok(())
        }
    })
}

/// A state's document and its arrays, with the bytes of each.
fn split(saved: &Bound<'_, PyAny>) -> PyResult<(Contents, Vec<Vec<u8>>)> {
    let py = saved.py();
    let numpy = py.import("numpy")?;
    let array_type = numpy.getattr("ndarray")?;
    let saved = saved.cast::<PyDict>().map_err(|_| {
        PyTypeError::new_err("save_state must give a dictionary from names to arrays and values")
    })?;
    let (document, mut arrays, mut bytes) = (PyDict::new(py), Vec::new(), Vec::new());
    for (name, value) in saved {
        if !value.is_instance(&array_type)? {
            document.set_item(name, value)?;
            continue;
        }
        let dtype = value.getattr("dtype")?;
        if dtype.getattr("hasobject")?.is_truthy()? || !dtype.getattr("names")?.is_none() {
            return Err(PyTypeError::new_err(format!(
                "the array `{name}` has elements that are no plain numbers; keep an array for each field"
            )));
        }
        arrays.push(KeptArray {
            name: name.extract()?,
            dtype: dtype.getattr("str")?.extract()?,
            shape: value.getattr("shape")?.extract()?,
        });
        bytes.push(value.call_method0("tobytes")?.extract::<Vec<u8>>()?);
    }
    let document = crate::documents::to_json(document.as_any())?;
    Ok((Contents { document, arrays }, bytes))
}

/// The dictionary of a state that is put back.
fn restore<'py>(
    py: Python<'py>,
    state: &mut StateExchange<'_>,
) -> Result<PyResult<Bound<'py, PyAny>>, StateError> {
    let mut contents = Contents::default();
    state.value("contents", &mut contents)?;
    let mut bytes = Vec::new();
    for array in &contents.arrays {
        let mut values = Vec::<u8>::new();
        state.list(&format!("array.{}", array.name), &mut values)?;
        bytes.push(values);
    }
    let join = || -> PyResult<Bound<'py, PyAny>> {
        let numpy = py.import("numpy")?;
        let given = py.import("json")?.call_method1("loads", (&contents.document,))?;
        for (array, bytes) in contents.arrays.iter().zip(&bytes) {
            let flat = numpy.call_method1("frombuffer", (PyBytes::new(py, bytes), &array.dtype))?;
            let shaped = flat.call_method1("reshape", (array.shape.clone(),))?;
            given.set_item(&array.name, shaped.call_method0("copy")?)?;
        }
        Ok(given)
    };
    Ok(join())
}
