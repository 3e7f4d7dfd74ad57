//! How functions of a component say what went wrong.

use crate::text::text_of;
use std::cell::RefCell;
use std::ffi::{c_char, c_int};
use tremie_messages::Problem;
use tremie_sdk::SolverError;

thread_local! {
    static FAILURE: RefCell<Option<String>> = const { RefCell::new(None) };
    static PROBLEMS: RefCell<Vec<Problem>> = const { RefCell::new(Vec::new()) };
}

/// Says why the function that calls it fails: a sentence. Gives 1, for `return tremie_fail("...");`.
///
/// # Safety
/// `why` ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_fail(why: *const c_char) -> c_int {
    // SAFETY: the caller's promise.
    let why = unsafe { text_of(why) };
    FAILURE.set(Some(why));
    1
}

/// Says a fault of a user's input, in `describe` and in `create`: the manifest's key, as
/// `scene.fluid.viscosity`, or `@cell` of the component's own table; what was found and expected; and a
/// remedy, or null. Gives 1.
///
/// # Safety
/// The texts end with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_problem(
    key: *const c_char,
    message: *const c_char,
    help: *const c_char,
) -> c_int {
    // SAFETY: the caller's promise.
    let (key, message) = unsafe { (text_of(key), text_of(message)) };
    // SAFETY: the caller's promise.
    let help = (!help.is_null()).then(|| unsafe { text_of(help) });
    PROBLEMS.with_borrow_mut(|all| all.push(Problem { key, message, help }));
    1
}

/// The outcome of a function that gave `code`.
pub(crate) fn outcome(function: &str, code: c_int) -> Result<(), SolverError> {
    match (code, FAILURE.take()) {
        (0, _) => Ok(()),
        (_, Some(why)) => Err(SolverError(why)),
        (code, None) => {
            Err(SolverError(format!("{function} gave {code}, and no reason by tremie_fail")))
        }
    }
}

/// The outcome of `describe` or `create`: problems, or a failure as one.
pub(crate) fn verdict(function: &str, failed: bool) -> Result<(), Vec<Problem>> {
    let problems = PROBLEMS.take();
    match (failed, problems.is_empty()) {
        (_, false) => Err(problems),
        (false, true) => Ok(()),
        (true, true) => {
            let error = outcome(function, 1).map_or_else(|error| error.0, |()| String::new());
            Err(vec![Problem::new("", error)])
        }
    }
}
