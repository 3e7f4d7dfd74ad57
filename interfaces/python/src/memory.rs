//! Values of messages as arrays of NumPy, where they lie.
//!
//! A component sees the memory of its channels: no value is copied. That memory is lent for one call. A view
//! that is kept beyond it would show another window's values, or nothing; so it is an error.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyDict;
use std::mem::{offset_of, size_of};
use std::sync::Arc;
use tremie_messages::frame::{BodySample, ProfileBin, SliceNode, SurfaceSample};
use tremie_messages::{BodyEvent, BodyState, Load, Message, SurfaceVertex};

/// Bytes that NumPy sees through `__array_interface__`.
#[pyclass(frozen, module = "tremie._tremie")]
struct LentMemory {
    address: usize,
    bytes: usize,
    writable: bool,
    /// Lives as long as any array that shows these bytes.
    _shown: Arc<()>,
}

#[pymethods]
impl LentMemory {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let interface = PyDict::new(py);
        interface.set_item("version", 3)?;
        interface.set_item("typestr", "|u1")?;
        interface.set_item("shape", (self.bytes,))?;
        interface.set_item("data", (self.address, !self.writable))?;
        Ok(interface)
    }
}

/// A field of a message: name, NumPy's type, numbers in a row, offset [bytes].
type Field = (&'static str, &'static str, usize, usize);

/// A message whose fields Python knows by name.
pub trait Structured: Message {
    /// Name of the layout in the package.
    const LAYOUT: &'static str;
    /// Its fields.
    const FIELDS: &'static [Field];
}

macro_rules! structured {
    ($($message:ty, $layout:literal { $($name:literal: $kind:literal x $row:literal at $($at:tt).+),+ $(,)? })+) => {$(
        impl Structured for $message {
            const LAYOUT: &'static str = $layout;
            const FIELDS: &'static [Field] =
                &[$(($name, $kind, $row, offset_of!($message, $($at).+))),+];
        }
    )+};
}

structured! {
    BodyState, "body_state" {
        "id": "<u8" x 1 at id, "position": "<f8" x 3 at position, "orientation": "<f8" x 4 at orientation,
        "velocity": "<f8" x 3 at velocity, "angular_velocity": "<f8" x 3 at angular_velocity,
    }
    Load, "load" { "id": "<u8" x 1 at id, "force": "<f8" x 3 at force, "torque": "<f8" x 3 at torque }
    BodyEvent, "body_event" {
        "id": "<u8" x 1 at id, "kind": "<u4" x 1 at kind, "shape": "<u4" x 1 at shape,
        "motion": "<u4" x 1 at motion, "set": "<u4" x 1 at set, "mass": "<f8" x 1 at mass,
        "size": "<f8" x 3 at size, "table": "<u8" x 1 at table,
    }
    BodySample, "body_sample" {
        "id": "<u8" x 1 at state.id, "position": "<f8" x 3 at state.position,
        "orientation": "<f8" x 4 at state.orientation, "velocity": "<f8" x 3 at state.velocity,
        "angular_velocity": "<f8" x 3 at state.angular_velocity, "radius": "<f8" x 1 at radius,
        "mass": "<f8" x 1 at mass, "set": "<u4" x 1 at set, "shape": "<u4" x 1 at shape,
        "motion": "<u4" x 1 at motion, "part": "<u4" x 1 at part,
    }
    SurfaceVertex, "surface_vertex" { "position": "<f8" x 3 at position, "velocity": "<f8" x 3 at velocity }
    SurfaceSample, "surface_sample" {
        "position": "<f8" x 3 at vertex.position, "velocity": "<f8" x 3 at vertex.velocity,
        "strain": "<f8" x 1 at strain,
    }
    SliceNode, "node" {
        "velocity": "<f4" x 3 at velocity, "pressure": "<f4" x 1 at pressure, "fill": "<f4" x 1 at fill,
        "solid": "<u4" x 1 at solid, "density": "<f4" x 1 at density, "level": "<u4" x 1 at level,
    }
    ProfileBin, "profile_bin" {
        "grains": "<f8" x 1 at grains, "solid_fraction": "<f8" x 1 at solid_fraction,
        "velocity": "<f8" x 3 at velocity, "fluctuation": "<f8" x 3 at fluctuation,
        "temperature": "<f8" x 1 at temperature, "coordination": "<f8" x 1 at coordination,
        "contact_stress": "<f8" x 6 at contact_stress, "kinetic_stress": "<f8" x 6 at kinetic_stress,
    }
}

/// NumPy's type of a message.
fn dtype<'py, T: Structured>(py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
    let layout = PyDict::new(py);
    let each = |pick: fn(&Field) -> usize| T::FIELDS.iter().map(pick).collect::<Vec<_>>();
    layout.set_item("names", T::FIELDS.iter().map(|field| field.0).collect::<Vec<_>>())?;
    let format = |(_, kind, row, _): &Field| match row {
        1 => (*kind).to_string(),
        _ => format!("({row},){kind}"),
    };
    layout.set_item("formats", T::FIELDS.iter().map(format).collect::<Vec<_>>())?;
    layout.set_item("offsets", each(|field| field.3))?;
    layout.set_item("itemsize", size_of::<T>())?;
    py.import("numpy")?.getattr("dtype")?.call1((layout,))
}

/// NumPy's types of all messages, by the names of their layouts.
#[pyfunction]
pub fn layouts<'py>(py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    all.set_item(BodyState::LAYOUT, dtype::<BodyState>(py)?)?;
    all.set_item(Load::LAYOUT, dtype::<Load>(py)?)?;
    all.set_item(BodyEvent::LAYOUT, dtype::<BodyEvent>(py)?)?;
    all.set_item(BodySample::LAYOUT, dtype::<BodySample>(py)?)?;
    all.set_item(SurfaceVertex::LAYOUT, dtype::<SurfaceVertex>(py)?)?;
    all.set_item(SurfaceSample::LAYOUT, dtype::<SurfaceSample>(py)?)?;
    all.set_item(SliceNode::LAYOUT, dtype::<SliceNode>(py)?)?;
    all.set_item(ProfileBin::LAYOUT, dtype::<ProfileBin>(py)?)?;
    Ok(all)
}

/// Functions and types that every call needs, looked up once.
fn looked_up<'py, T: Structured>(
    py: Python<'py>,
) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    static TYPES: PyOnceLock<Py<PyDict>> = PyOnceLock::new();
    let asarray = ASARRAY
        .get_or_try_init(py, || Ok::<_, PyErr>(py.import("numpy")?.getattr("asarray")?.unbind()))?;
    let types = TYPES.get_or_try_init(py, || Ok::<_, PyErr>(layouts(py)?.unbind()))?;
    let dtype = types.bind(py).as_any().get_item(T::LAYOUT)?;
    Ok((asarray.bind(py).clone(), dtype))
}

/// An array over lent memory, and whether anybody still has it.
pub struct Lent<'py> {
    /// The array.
    pub array: Bound<'py, PyAny>,
    shown: Arc<()>,
}

impl<'py> Lent<'py> {
    fn over<T: Structured>(
        py: Python<'py>,
        address: *const T,
        length: usize,
        writable: bool,
    ) -> PyResult<Self> {
        let shown = Arc::new(());
        let bytes = length * size_of::<T>();
        let address = address as usize;
        let memory =
            Bound::new(py, LentMemory { address, bytes, writable, _shown: shown.clone() })?;
        let (asarray, dtype) = looked_up::<T>(py)?;
        let array = asarray.call1((memory,))?.call_method1("view", (dtype,))?;
        Ok(Self { array, shown })
    }

    /// Values to read. The caller must call [`Lent::give_back`] before they end.
    pub fn read<T: Structured>(py: Python<'py>, values: &[T]) -> PyResult<Self> {
        Self::over(py, values.as_ptr(), values.len(), false)
    }

    /// Values to write. The caller must call [`Lent::give_back`] before they end.
    pub fn write<T: Structured>(py: Python<'py>, values: &mut [T]) -> PyResult<Self> {
        Self::over(py, values.as_ptr(), values.len(), true)
    }

    /// Ends the loan; says false if somebody has kept a view.
    pub fn give_back(self) -> bool {
        drop(self.array);
        Arc::strong_count(&self.shown) == 1
    }
}

/// An array of its own with a copy of values.
pub fn copied<'py, T: Structured>(py: Python<'py>, values: &[T]) -> PyResult<Bound<'py, PyAny>> {
    let lent = Lent::read(py, values)?;
    let copy = lent.array.call_method0("copy")?;
    lent.give_back();
    Ok(copy)
}
