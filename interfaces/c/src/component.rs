//! What the tables have in common: functions that describe a component, make it and end it.

use crate::description::OwnDescription;
use crate::failure::verdict;
use crate::setup::RunSetup;
use std::ffi::{c_int, c_void};
use tremie_messages::Problem;
use tremie_messages::start::Description;
use tremie_sdk::Setup;

/// What a component says of itself by the `describe` of its table.
pub fn described(
    setup: &Setup,
    describe: extern "C" fn(*const RunSetup, *mut OwnDescription) -> c_int,
) -> Result<Description, Vec<Problem>> {
    let mut description = OwnDescription::default();
    let code = describe(&RunSetup::new(setup)?, &raw mut description);
    verdict("describe", code != 0)?;
    Ok(description.0)
}

/// A component that the `create` of a table has made; its `destroy` ends it.
pub struct Made {
    /// What the functions of the table take as `self`.
    pub own: *mut c_void,
    destroy: extern "C" fn(*mut c_void),
}

impl Made {
    /// Makes the component.
    pub fn new(
        setup: &Setup,
        create: extern "C" fn(*const RunSetup) -> *mut c_void,
        destroy: extern "C" fn(*mut c_void),
    ) -> Result<Self, Vec<Problem>> {
        let own = create(&RunSetup::new(setup)?);
        verdict("create", own.is_null())?;
        Ok(Self { own, destroy })
    }

    /// Appends so many values of signals, if the component has any.
    pub fn push_signals(
        &self,
        signals: Option<extern "C" fn(*mut c_void, *mut f64, usize)>,
        count: usize,
        values: &mut Vec<f64>,
    ) {
        let Some(signals) = signals else { return };
        let before = values.len();
        values.resize(before + count, 0.0);
        signals(self.own, values[before..].as_mut_ptr(), count);
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        (self.destroy)(self.own);
    }
}
