//! The run as a component of C knows it.

use crate::text::{c_text, text_of};
use serde_json::Value;
use std::ffi::{CString, c_char, c_int};
use tremie_messages::Problem;
use tremie_messages::units;
use tremie_sdk::Setup;

/// The run as a component knows it. Opaque.
pub struct RunSetup {
    document: Value,
    text: CString,
    output: CString,
    component: CString,
    step: f64,
    substeps: u32,
    window: f64,
    threads: u32,
}

impl RunSetup {
    /// Of a run.
    pub(crate) fn new(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let document = serde_json::json!({
            "scene": setup.hello.scene,
            "parameters": setup.hello.parameters,
        });
        let assignment = setup.assignment.as_ref();
        Ok(Self {
            text: c_text(&document.to_string()),
            output: c_text(&setup.hello.output),
            component: c_text(&setup.hello.component),
            step: assignment.map_or(0.0, |assignment| assignment.step),
            substeps: assignment.map_or(0, |assignment| assignment.substeps),
            window: assignment.map_or(0.0, |assignment| assignment.clock.window()),
            threads: setup.hello.threads,
            document,
        })
    }

    /// What stands at a path, as `scene.fluid.density`, `scene.gravity[2]` or `parameters.cell`.
    fn at(&self, path: &str) -> Option<&Value> {
        let mut steps = path.split(['.', '[']).map(|step| step.trim_end_matches(']'));
        steps.try_fold(&self.document, |at, step| match (at, step.parse::<usize>()) {
            (Value::Array(list), Ok(place)) => list.get(place),
            (value, _) => value.get(step),
        })
    }
}

/// The scene (in SI units) and the component's own table, as one JSON document
/// `{"scene": .., "parameters": ..}`. Valid as long as the setup.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_json(setup: *const RunSetup) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { (*setup).text.as_ptr() }
}

/// Folder of the run's outputs. Valid as long as the setup.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_output(setup: *const RunSetup) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { (*setup).output.as_ptr() }
}

/// Name of the component in this run. Valid as long as the setup.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_component(setup: *const RunSetup) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { (*setup).component.as_ptr() }
}

/// Reads the number at a path, as `scene.fluid.density`, `scene.gravity[2]` or `parameters.count`. Gives 0
/// if there is one.
///
/// # Safety
/// `setup` comes from the library, `path` ends with a zero, and `value` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_number(
    setup: *const RunSetup,
    path: *const c_char,
    value: *mut f64,
) -> c_int {
    // SAFETY: the caller's promise.
    let (setup, path) = unsafe { (&*setup, text_of(path)) };
    let Some(found) = setup.at(&path).and_then(Value::as_f64) else { return 1 };
    // SAFETY: the caller's promise.
    unsafe { *value = found };
    0
}

/// Reads the quantity with its unit at a path of the component's own table, as `parameters.cell`, into SI
/// units; `kind` is length, area, volume, time, velocity, angular velocity, acceleration, mass, density,
/// viscosity, force, stiffness, dashpot, pressure, temperature, angle or frequency. Gives 0 if there is one.
///
/// # Safety
/// `setup` comes from the library, the texts end with a zero, and `value` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_quantity(
    setup: *const RunSetup,
    path: *const c_char,
    kind: *const c_char,
    value: *mut f64,
) -> c_int {
    // SAFETY: the caller's promise.
    let (setup, path, kind) = unsafe { (&*setup, text_of(path), text_of(kind)) };
    let text = setup.at(&path).and_then(Value::as_str);
    let Some(Ok(found)) = text.and_then(|text| units::read(&kind, text)) else { return 1 };
    // SAFETY: the caller's promise.
    unsafe { *value = found };
    0
}

/// Length of a substep [s]; 0 in `describe`.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_step(setup: *const RunSetup) -> f64 {
    // SAFETY: the caller's promise.
    unsafe { (*setup).step }
}

/// Substeps in a coupling window; 0 in `describe`.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_substeps(setup: *const RunSetup) -> u32 {
    // SAFETY: the caller's promise.
    unsafe { (*setup).substeps }
}

/// Length of a coupling window [s]; 0 in `describe`.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_window(setup: *const RunSetup) -> f64 {
    // SAFETY: the caller's promise.
    unsafe { (*setup).window }
}

/// Threads that the component may use.
///
/// # Safety
/// `setup` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_setup_threads(setup: *const RunSetup) -> u32 {
    // SAFETY: the caller's promise.
    unsafe { (*setup).threads }
}
