//! What runs left: their signals, and the frames of their recordings.

use crate::memory::copied;
use pyo3::exceptions::{PyFileNotFoundError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::{Path, PathBuf};
use tremie_messages::frame::{ProfileHeader, SliceHeader, VolumeHeader};
use tremie_recorder::{Item, Items, ReadError, Recording};
use tremie_results::Signals;

/// Times, and a column and a unit for each signal of `signals.csv`.
#[pyfunction]
pub fn read_signals<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyAny>> {
    let wrong = |error: tremie_results::UnreadableSignals| unreadable(&path, error.to_string());
    let signals = py.detach(|| Signals::read(&path)).map_err(wrong)?;
    let array = |values: &[f64]| -> PyResult<Bound<'py, PyAny>> {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let bytes = pyo3::types::PyBytes::new(py, &bytes);
        py.import("numpy")?.call_method1("frombuffer", (bytes, "<f8"))?.call_method0("copy")
    };
    let columns = PyDict::new(py);
    for (name, values) in &signals.columns {
        columns.set_item(name, array(values)?)?;
    }
    let cut = signals.cut.as_ref().map(ToString::to_string);
    Ok((array(&signals.times)?, columns, signals.units, cut).into_pyobject(py)?.into_any())
}

fn unreadable(path: &Path, why: String) -> PyErr {
    match path.exists() {
        true => PyValueError::new_err(why),
        false => PyFileNotFoundError::new_err(why),
    }
}

/// Frames of a recording, in their order: tuples of the kind, the sender, the name, the window, the time, the
/// header and the values.
#[pyclass(unsendable, module = "tremie._tremie")]
pub struct Frames {
    items: Items,
}

#[pymethods]
impl Frames {
    /// Of the recording at `path`, those of one kind: `bodies`, `surfaces` or `slice`.
    #[new]
    fn new(path: PathBuf, kind: &str) -> PyResult<Self> {
        let wrong = |error: ReadError| unreadable(&path, format!("{}: {error}", path.display()));
        let recording = Recording::open(&path).map_err(wrong)?;
        let part = match kind {
            "bodies" => "/bodies/",
            "surfaces" => "/surfaces/",
            "slice" => "/cuts/",
            _ => {
                let why =
                    format!("there are no frames \"{kind}\"; there are bodies, surfaces, slice");
                return Err(PyValueError::new_err(why));
            }
        };
        Ok(Self { items: recording.items_of(move |topic| topic.starts_with(part)) })
    }

    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        for item in self.items.by_ref() {
            let item = item.map_err(|error| PyValueError::new_err(error.to_string()))?;
            if let Some(frame) = frame(py, item)? {
                return Ok(Some(frame));
            }
        }
        Ok(None)
    }
}

/// A frame as a tuple; `None` of one that has no array.
fn frame<'py>(py: Python<'py>, item: Item) -> PyResult<Option<Bound<'py, PyAny>>> {
    let frame = match item {
        Item::Bodies { from, at, bodies } => {
            ("bodies", from, "", at.stamp.window, at.time, py.None(), copied(py, &bodies)?)
                .into_pyobject(py)?
        }
        Item::Surfaces { from, at, samples } => {
            ("surfaces", from, "", at.stamp.window, at.time, py.None(), copied(py, &samples)?)
                .into_pyobject(py)?
        }
        Item::Slice { from, name, at, header, nodes } => {
            let header = slice_header(py, &header)?;
            ("slice", from, name, at.stamp.window, at.time, header, copied(py, &nodes)?)
                .into_pyobject(py)?
        }
        _ => return Ok(None),
    };
    Ok(Some(frame.into_any()))
}

/// Grid of a cut.
pub fn slice_header<'py>(py: Python<'py>, header: &SliceHeader) -> PyResult<Bound<'py, PyDict>> {
    let grid = PyDict::new(py);
    grid.set_item("origin", header.origin)?;
    grid.set_item("step", header.step)?;
    grid.set_item("count", PyList::new(py, header.count)?)?;
    Ok(grid)
}

/// Grid of a volume.
pub fn volume_header<'py>(py: Python<'py>, header: &VolumeHeader) -> PyResult<Bound<'py, PyDict>> {
    let grid = PyDict::new(py);
    grid.set_item("origin", header.origin)?;
    grid.set_item("step", header.step)?;
    grid.set_item("count", PyList::new(py, header.count)?)?;
    Ok(grid)
}

/// Times and samples of a table of a profile.
pub fn profile_header<'py>(
    py: Python<'py>,
    header: &ProfileHeader,
) -> PyResult<Bound<'py, PyDict>> {
    let table = PyDict::new(py);
    table.set_item("begin", header.begin)?;
    table.set_item("end", header.end)?;
    table.set_item("samples", header.samples)?;
    Ok(table)
}
