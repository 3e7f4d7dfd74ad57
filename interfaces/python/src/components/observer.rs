//! A class of Python as an observer of a run.

use super::call::{call_lending, create, describe, raised};
use super::{UNNAMED, program, state};
use crate::memory::{Lent, Structured};
use crate::results::{profile_header, slice_header, volume_header};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use tremie_messages::Problem;
use tremie_messages::frame::{
    BodySample, LogHeader, ProfileBin, ProfileHeader, SliceHeader, SliceNode, SurfaceSample,
    VolumeHeader,
};
use tremie_messages::start::{Description, Signal};
use tremie_sdk::state::{StateError, StateExchange};
use tremie_sdk::{Moment, Observer, ObserverError, Setup};

/// An observer that a class of Python is.
pub struct PythonObserver {
    observer: Py<PyAny>,
}

impl Observer for PythonObserver {
    const PROGRAM: &'static str = UNNAMED;

    fn program() -> String {
        program()
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        describe(setup)
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        Ok(Self { observer: create(setup)? })
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state::exchange(&self.observer, state)
    }

    fn bodies(
        &mut self,
        from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        self.show(at, "bodies", &[from], None, ("bodies", bodies))
    }

    fn surfaces(
        &mut self,
        from: &str,
        at: Moment,
        samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        self.show(at, "surfaces", &[from], None, ("vertices", samples))
    }

    fn slice(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        let grid = Python::attach(|py| slice_header(py, header).map(Bound::unbind));
        self.show(at, "slice", &[from, name], Some(grid), ("nodes", nodes))
    }

    fn volume(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &VolumeHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        let grid = Python::attach(|py| volume_header(py, header).map(Bound::unbind));
        self.show(at, "volume", &[from, name], Some(grid), ("nodes", nodes))
    }

    fn profile(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &ProfileHeader,
        bins: &[ProfileBin],
    ) -> Result<(), ObserverError> {
        let times = Python::attach(|py| profile_header(py, header).map(Bound::unbind));
        self.show(at, "profile", &[from, name], Some(times), ("bins", bins))
    }

    fn signals(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError> {
        self.tell("signals", |py| {
            let pairs = PyDict::new(py);
            for (signal, value) in names.iter().zip(values) {
                pairs.set_item(&signal.name, value)?;
            }
            let from = PyString::new(py, from).into_any();
            Ok(vec![from, moment(py, at)?, pairs.into_any()])
        })
    }

    fn log(&mut self, at: Moment, header: &LogHeader, text: &str) -> Result<(), ObserverError> {
        let level = match header.level {
            LogHeader::INFO => "info",
            LogHeader::WARNING => "warning",
            _ => "error",
        };
        self.tell("log", |py| {
            let words = [level, text].map(|word| PyString::new(py, word).into_any());
            let [level, text] = words;
            Ok(vec![moment(py, at)?, level, text])
        })
    }

    fn close(&mut self, last_common_window: u64) -> Result<String, ObserverError> {
        Python::attach(|py| {
            let note = self.observer.bind(py).call_method1("close", (last_common_window,));
            let note = note.and_then(|note| note.extract::<Option<String>>());
            note.map(Option::unwrap_or_default).map_err(|error| wrong(py, "close", &error))
        })
    }
}

impl PythonObserver {
    /// Shows values of a frame where they lie.
    fn show<T: Structured>(
        &self,
        at: Moment,
        method: &str,
        words: &[&str],
        header: Option<PyResult<Py<PyDict>>>,
        (name, values): (&str, &[T]),
    ) -> Result<(), ObserverError> {
        Python::attach(|py| {
            let arguments = || -> PyResult<_> {
                let mut leading: Vec<_> =
                    words.iter().map(|word| PyString::new(py, word).into_any()).collect();
                leading.push(moment(py, at)?);
                if let Some(header) = header {
                    leading.push(header?.into_bound(py).into_any());
                }
                Ok((leading, Lent::read(py, values)?))
            };
            let (leading, lent) = arguments().map_err(|error| wrong(py, method, &error))?;
            let called = call_lending(self.observer.bind(py), method, leading, vec![(name, lent)]);
            called.map(drop).map_err(ObserverError::Output)
        })
    }

    /// Calls a method with arguments of its own.
    fn tell<'a>(
        &self,
        method: &str,
        arguments: impl for<'py> FnOnce(Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> + 'a,
    ) -> Result<(), ObserverError> {
        Python::attach(|py| {
            let arguments = arguments(py).map_err(|error| wrong(py, method, &error))?;
            let called = call_lending(self.observer.bind(py), method, arguments, Vec::new());
            called.map(drop).map_err(ObserverError::Output)
        })
    }
}

/// An observer that fails has lost an output, as far as anybody can know: that ends the run.
fn wrong(py: Python<'_>, method: &str, error: &PyErr) -> ObserverError {
    match error.is_instance_of::<PyOSError>(py) {
        true => ObserverError::Output(error.value(py).to_string()),
        false => ObserverError::Output(raised(py, method, error)),
    }
}

/// `tremie.Moment`: window and simulated time.
fn moment<'py>(py: Python<'py>, at: Moment) -> PyResult<Bound<'py, PyAny>> {
    py.import("tremie")?.getattr("Moment")?.call1((at.stamp.window, at.time))
}
