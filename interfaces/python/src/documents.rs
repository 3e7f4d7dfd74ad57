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
    macro_rules! read {
        ($($name:literal => $quantity:ident),+ $(,)?) => {
            match kind {
                $($name => text.parse().map(|units::$quantity(value)| value),)+
                _ => {
                    let known = [$($name),+].join(", ");
                    let why = format!("there is no kind of quantity \"{kind}\"; there are {known}");
                    return Err(PyValueError::new_err(why));
                }
            }
        };
    }
    let value = read! {
        "length" => Length, "area" => Area, "volume" => Volume, "time" => Time,
        "velocity" => Velocity, "angular velocity" => AngularVelocity,
        "acceleration" => Acceleration, "mass" => Mass, "density" => Density,
        "viscosity" => Viscosity, "force" => Force, "stiffness" => Stiffness,
        "dashpot" => Dashpot, "pressure" => Pressure, "temperature" => Temperature,
        "angle" => Angle, "frequency" => Frequency,
    };
    value.map_err(|error: units::NotAQuantity| PyValueError::new_err(error.to_string()))
}
