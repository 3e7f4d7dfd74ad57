//! States of components of C: named once for keeping them and for putting them back.

use crate::text::text_of;
use std::ffi::{c_char, c_int};
use tremie_sdk::state::{StateError, StateExchange};

/// A state on its way out of a component, or back into it. Opaque.
pub struct ComponentState {
    /// The exchange, whose own lifetime C cannot know.
    exchange: *mut StateExchange<'static>,
    error: Option<StateError>,
}

impl ComponentState {
    /// Exchanges a state by a function of the component, which gives its code.
    pub(crate) fn exchange(
        state: &mut StateExchange<'_>,
        tell: impl FnOnce(*mut ComponentState) -> c_int,
    ) -> Result<(), StateError> {
        let exchange: *mut StateExchange<'_> = state;
        let mut own = Self { exchange: exchange.cast(), error: None };
        let code = tell(&raw mut own);
        match own.error.take() {
            Some(error) => Err(error),
            None => crate::failure::outcome("exchange_state", code)
                .map_err(|error| StateError::Unfit(error.0)),
        }
    }

    fn with(
        &mut self,
        tell: impl FnOnce(&mut StateExchange<'static>) -> Result<(), StateError>,
    ) -> c_int {
        // SAFETY: `exchange` outlives the call of the component's function, and this object lives no
        // longer than that.
        let told = tell(unsafe { &mut *self.exchange });
        let failed = told.is_err();
        self.error = self.error.take().or(told.err());
        c_int::from(failed)
    }
}

/// 1 if the state is put back, 0 if it is kept.
///
/// # Safety
/// `state` comes from the library.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_state_restores(state: *const ComponentState) -> c_int {
    // SAFETY: the caller's promise, and `exchange` outlives the call.
    c_int::from(unsafe { (*(*state).exchange).restores() })
}

/// A whole number, as a length for which a component makes room before it names an array. Gives 0, or
/// something else for a state that does not fit: then give that back.
///
/// # Safety
/// `state` comes from the library, the name ends with a zero, `value` can be read and written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_state_count(
    state: *mut ComponentState,
    name: *const c_char,
    value: *mut u64,
) -> c_int {
    // SAFETY: the caller's promise.
    let (state, name, value) = unsafe { (&mut *state, text_of(name), &mut *value) };
    state.with(|exchange| exchange.value(&name, value))
}

/// Numbers in double precision. Gives 0, or something else for a state that does not fit: then give that back.
///
/// # Safety
/// `state` comes from the library, the name ends with a zero, and `count` values can be read and written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_state_doubles(
    state: *mut ComponentState,
    name: *const c_char,
    values: *mut f64,
    count: usize,
) -> c_int {
    // SAFETY: the caller's promise.
    let (state, name, values) = unsafe { (&mut *state, text_of(name), array(values, count)) };
    state.with(|exchange| exchange.array(&name, values))
}

/// Whole numbers. Gives 0, or something else for a state that does not fit: then give that back.
///
/// # Safety
/// `state` comes from the library, the name ends with a zero, and `count` values can be read and written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_state_integers(
    state: *mut ComponentState,
    name: *const c_char,
    values: *mut u64,
    count: usize,
) -> c_int {
    // SAFETY: the caller's promise.
    let (state, name, values) = unsafe { (&mut *state, text_of(name), array(values, count)) };
    state.with(|exchange| exchange.array(&name, values))
}

/// Values that C has; none where it has no address for them.
///
/// # Safety
/// `values` is null, or so many can be read and written.
unsafe fn array<'a, T>(values: *mut T, count: usize) -> &'a mut [T] {
    match values.is_null() {
        true => &mut [],
        // SAFETY: the caller's promise.
        false => unsafe { std::slice::from_raw_parts_mut(values, count) },
    }
}
