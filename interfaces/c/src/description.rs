//! What a component of C says of itself.

use crate::text::text_of;
use std::ffi::c_char;
use tremie_messages::start::{Description, Signal};

/// What a component says of itself before a run is planned. Opaque.
#[derive(Default)]
pub struct OwnDescription(pub(crate) Description);

/// The longest step that is stable and accurate [s], and what limits it, in a few words. Not called, the
/// component takes any.
///
/// # Safety
/// `description` comes from the library; the text ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_step(
    description: *mut OwnDescription,
    step: f64,
    limit: *const c_char,
) {
    // SAFETY: the caller's promise.
    let (description, limit) = unsafe { (&mut (*description).0, text_of(limit)) };
    (description.step, description.step_limit) = (Some(step), limit);
}

/// Number of bodies that grains bring.
///
/// # Safety
/// `description` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_bodies(description: *mut OwnDescription, bodies: u64) {
    // SAFETY: the caller's promise.
    unsafe { (*description).0.bodies = bodies };
}

/// A scalar that the component reports: name in snake case, SI unit (1 if none), meaning. `signals` gives the
/// values in the order of these calls.
///
/// # Safety
/// `description` comes from the library; the texts end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_signal(
    description: *mut OwnDescription,
    name: *const c_char,
    unit: *const c_char,
    meaning: *const c_char,
) {
    // SAFETY: the caller's promise.
    let (name, unit, meaning) = unsafe { (text_of(name), text_of(unit), text_of(meaning)) };
    let signal = Signal { name, unit, meaning, sampled: false };
    // SAFETY: the caller's promise.
    unsafe { (*description).0.signals.push(signal) };
}

/// A line for the plan.
///
/// # Safety
/// `description` comes from the library; the text ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_note(
    description: *mut OwnDescription,
    note: *const c_char,
) {
    // SAFETY: the caller's promise.
    unsafe { (*description).0.notes.push(text_of(note)) };
}

/// Something doubtful, with the remedy.
///
/// # Safety
/// `description` comes from the library; the text ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_warning(
    description: *mut OwnDescription,
    warning: *const c_char,
) {
    // SAFETY: the caller's promise.
    unsafe { (*description).0.warnings.push(text_of(warning)) };
}

/// The component has `exchange_state`; another version whenever that names other things.
///
/// # Safety
/// `description` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_describe_state(description: *mut OwnDescription, version: u32) {
    // SAFETY: the caller's promise.
    unsafe { (*description).0.state = Some(version) };
}
