//! The module that the Python package `tremie` stands on.
//!
//! `components` lets classes of Python play roles in runs, with the shared memory of the channels as
//! their arrays. `results` reads what runs left. `program` is the whole `tremie` program.
//! What a user sees is written in Python, in `tremie/`; this module has only what that needs.

mod components;
mod documents;
mod memory;
mod program;
mod results;

use pyo3::prelude::*;

/// The parts that the package needs.
#[pymodule]
fn _tremie(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(memory::layouts, module)?)?;
    module.add_function(wrap_pyfunction!(components::serve, module)?)?;
    module.add_function(wrap_pyfunction!(program::program, module)?)?;
    module.add_function(wrap_pyfunction!(documents::quantity, module)?)?;
    module.add_function(wrap_pyfunction!(documents::read_toml, module)?)?;
    module.add_function(wrap_pyfunction!(results::read_signals, module)?)?;
    module.add_class::<results::Frames>()
}
