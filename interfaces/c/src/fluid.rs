//! Fluids of C.

use crate::component::{Made, described};
use crate::description::OwnDescription;
use crate::failure::outcome;
use crate::setup::RunSetup;
use crate::state::ComponentState;
use crate::text::text_of;
use std::ffi::{c_char, c_int, c_void};
use std::sync::OnceLock;
use tremie_messages::start::Description;
use tremie_messages::{BodyEvent, BodyState, Load, Problem};
use tremie_sdk::state::{StateError, StateExchange};
use tremie_sdk::{AsFluid, Fluid, Setup, SolverError, number_of};

/// A fluid: takes poses of bodies, gives the loads on them. `bodies` and `loads` have the same bodies in the same
/// order (ascending ids). `self` is what `create` gave. All functions run on one thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FluidTable {
    /// Name and version, for the log. The name also tells states of checkpoints from another's.
    pub program: *const c_char,
    /// Checks scene and parameters, and says what the fluid needs. Cheap.
    pub describe: extern "C" fn(*const RunSetup, *mut OwnDescription) -> c_int,
    /// Makes the fluid for the assigned step; null if it cannot.
    pub create: extern "C" fn(*const RunSetup) -> *mut c_void,
    /// Bodies that appear or disappear, effective with the next bodies.
    pub events: extern "C" fn(*mut c_void, *const BodyEvent, usize) -> c_int,
    /// Looks at the bodies at time zero, lets no time pass, writes the loads on them.
    pub start: extern "C" fn(*mut c_void, *const BodyState, *mut Load, usize) -> c_int,
    /// Advances through a window in so many substeps, and writes the mean loads, buoyancy included.
    pub advance: extern "C" fn(*mut c_void, u32, *const BodyState, *mut Load, usize) -> c_int,
    /// Writes the values of the signals, in the order of the description; null if there are none.
    pub signals: Option<extern "C" fn(*mut c_void, *mut f64, usize)>,
    /// Names the state, to keep it and to put it back; null if there is none.
    pub exchange_state: Option<extern "C" fn(*mut c_void, *mut ComponentState) -> c_int>,
    /// Ends the fluid.
    pub destroy: extern "C" fn(*mut c_void),
}

// SAFETY: a table of functions and a constant text, made before any thread is.
unsafe impl Send for FluidTable {}
// SAFETY: as above.
unsafe impl Sync for FluidTable {}

static TABLE: OnceLock<FluidTable> = OnceLock::new();

/// Takes part in a run as this fluid; gives the exit code of the process.
///
/// # Safety
/// `table` is whole, and its functions do what it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_fluid_main(table: *const FluidTable) -> c_int {
    // SAFETY: the caller's promise.
    let _ = TABLE.set(unsafe { *table });
    number_of(tremie_sdk::main::<AsFluid<CFluid>>()).into()
}

fn table() -> &'static FluidTable {
    TABLE.get().expect("tremie_fluid_main has set it")
}

/// A fluid that functions of C are.
struct CFluid {
    made: Made,
    signals: usize,
}

impl Fluid for CFluid {
    const PROGRAM: &'static str = "tremie-c";

    fn program() -> String {
        // SAFETY: the table is whole.
        unsafe { text_of(table().program) }
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        described(setup, table().describe)
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let signals = Self::describe(setup)?.signals.len();
        let made = Made::new(setup, table().create, table().destroy)?;
        Ok(Self { made, signals })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        outcome("events", (table().events)(self.made.own, events.as_ptr(), events.len()))
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        let count = bodies.len().min(loads.len());
        let code = (table().start)(self.made.own, bodies.as_ptr(), loads.as_mut_ptr(), count);
        outcome("start", code)
    }

    fn advance(
        &mut self,
        substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        let count = bodies.len().min(loads.len());
        let advance = table().advance;
        let code = advance(self.made.own, substeps, bodies.as_ptr(), loads.as_mut_ptr(), count);
        outcome("advance", code)
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        match table().exchange_state {
            Some(exchange) => {
                ComponentState::exchange(state, |state| exchange(self.made.own, state))
            }
            None => state.unfit("the fluid has a version of its state and no exchange_state"),
        }
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        self.made.push_signals(table().signals, self.signals, values);
    }
}
