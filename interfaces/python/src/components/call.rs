//! Calls of a component's methods, and what they raise.

use super::CLASS;
use super::setup::setup_of;
use crate::documents::to_json;
use crate::memory::Lent;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use tremie_messages::Problem;
use tremie_messages::start::Description;
use tremie_sdk::{Setup, SolverError};

/// What an exception says, its traceback included, after the name of the method that raised it.
pub fn raised(py: Python<'_>, method: &str, error: &PyErr) -> String {
    let lines = || -> PyResult<String> {
        let whole = (error.get_type(py), error.value(py), error.traceback(py));
        let lines = py.import("traceback")?.call_method1("format_exception", whole)?;
        Ok(lines.extract::<Vec<String>>()?.concat())
    };
    let traceback = lines().unwrap_or_else(|_| error.to_string());
    format!("{method} raised an exception\n{}", traceback.trim_end())
}

/// Calls a method, and refuses views of lent memory that outlive the call.
pub fn call_lending<'py>(
    object: &Bound<'py, PyAny>,
    method: &str,
    leading: Vec<Bound<'py, PyAny>>,
    lent: Vec<(&str, Lent<'py>)>,
) -> Result<Bound<'py, PyAny>, String> {
    let py = object.py();
    let arrays = lent.iter().map(|(_, lent)| lent.array.clone());
    let arguments: Vec<_> = leading.into_iter().chain(arrays).collect();
    let call = || object.call_method1(method, PyTuple::new(py, arguments)?);
    let answer = call().map_err(|error| raised(py, method, &error))?;
    for (name, lent) in lent {
        if !lent.give_back() {
            return Err(format!(
                "{method} kept `{name}`, or a view of it, beyond the call: that memory is another window's by \
                 then. Keep a copy: {name}.copy()"
            ));
        }
    }
    Ok(answer)
}

/// Problems that an exception says: those of `tremie.Problem` and `tremie.Problems`, else the exception.
pub fn problems_of(py: Python<'_>, method: &str, error: &PyErr) -> Vec<Problem> {
    let said = || -> PyResult<Option<Vec<Problem>>> {
        let all = py.import("tremie")?.call_method1("_problems_of", (error.value(py),))?;
        let Some(all) = all.extract::<Option<Vec<(String, String, Option<String>)>>>()? else {
            return Ok(None);
        };
        let problem = |(key, message, help)| Problem { key, message, help };
        Ok(Some(all.into_iter().map(problem).collect()))
    };
    match said() {
        Ok(Some(problems)) => problems,
        _ => vec![Problem::new("", raised(py, method, error))],
    }
}

/// The description that the class gives.
pub fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
    Python::attach(|py| {
        let class = class(py);
        let text = || -> PyResult<String> {
            let description = class.call_method1("_describe", (setup_of(py, setup)?,))?;
            to_json(&description)
        };
        let text = text().map_err(|error| problems_of(py, "describe", &error))?;
        serde_json::from_str(&text).map_err(|error| {
            vec![Problem::new("", format!("its description cannot be read: {error}"))]
        })
    })
}

/// The solver, or the observer, that the class makes.
pub fn create(setup: &Setup) -> Result<Py<PyAny>, Vec<Problem>> {
    Python::attach(|py| {
        let made = setup_of(py, setup).and_then(|setup| class(py).call1((setup,)));
        made.map(Bound::unbind).map_err(|error| problems_of(py, "__init__", &error))
    })
}

/// Says if the class has set an attribute to true.
pub fn says(attribute: &str) -> bool {
    Python::attach(|py| {
        class(py).getattr(attribute).and_then(|value| value.is_truthy()).unwrap_or(false)
    })
}

fn class(py: Python<'_>) -> Bound<'_, PyAny> {
    CLASS.get().map_or_else(|| py.None().into_bound(py), |class| class.bind(py).clone())
}

/// Pushes the values of a component's signals. The sdk lets no error through here; it takes a panic's text, as
/// the component's failure, and nothing is printed.
pub fn push_signals(solver: &Py<PyAny>, method: &str, values: &mut Vec<f64>) {
    let found = Python::attach(|py| {
        let found = solver.bind(py).call_method0(method).and_then(|found| {
            let list = py.import("builtins")?.getattr("list")?.call1((found,))?;
            list.extract::<Vec<f64>>()
        });
        found.map_err(|error| raised(py, method, &error))
    });
    match found {
        Ok(found) => values.extend(found),
        Err(why) => std::panic::resume_unwind(Box::new(why)),
    }
}

/// Fills a frame, and gives the header that the method answers with, or what went wrong.
pub fn fill_frame<'py>(
    solver: &Bound<'py, PyAny>,
    method: &str,
    leading: Vec<Bound<'py, PyAny>>,
    nodes: Lent<'py>,
) -> Result<Bound<'py, PyDict>, String> {
    let answer = call_lending(solver, method, leading, vec![("nodes", nodes)])?;
    answer.cast_into::<PyDict>().map_err(|_| {
        format!("{method} must give a dictionary with the frame's origin, step and count")
    })
}

/// A failure of the solver.
pub fn failed(why: String) -> SolverError {
    SolverError(why)
}
