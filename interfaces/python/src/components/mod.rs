//! Classes of Python as components: one class a process, in the role that its base says.

mod call;
mod fluid;
mod grains;
mod observer;
mod setup;
mod state;

use fluid::PythonFluid;
use grains::PythonGrains;
use observer::PythonObserver;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::OnceLock;
use tremie_sdk::{AsFluid, AsGrains, AsObserver, number_of};

/// The class that this process serves.
static CLASS: OnceLock<Py<PyAny>> = OnceLock::new();

/// Name and version that the class gives itself.
static PROGRAM: OnceLock<String> = OnceLock::new();

/// Takes part in a run as `class`, whose name and version is `program`, and gives the exit code of the process.
#[pyfunction]
pub fn serve(py: Python<'_>, role: &str, class: Bound<'_, PyAny>, program: String) -> PyResult<u8> {
    if CLASS.set(class.unbind()).is_err() || PROGRAM.set(program).is_err() {
        return Err(PyValueError::new_err("a process can be one component, once"));
    }
    let main = match role {
        "fluid" => tremie_sdk::main::<AsFluid<PythonFluid>>,
        "grains" => tremie_sdk::main::<AsGrains<PythonGrains>>,
        "observer" => tremie_sdk::main::<AsObserver<PythonObserver>>,
        _ => {
            let why = format!("there is no role \"{role}\"; there are fluid, grains and observer");
            return Err(PyValueError::new_err(why));
        }
    };
    Ok(py.detach(|| number_of(main())))
}

/// Name and version of the program that this process is.
fn program() -> String {
    PROGRAM.get().cloned().unwrap_or_else(|| UNNAMED.into())
}

/// Name of a program whose class has not been given yet.
const UNNAMED: &str = "tremie-python";
