//! Grains of C.

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
use tremie_sdk::{AsGrains, Grains, Setup, SolverError, number_of};

/// Grains: take the loads on bodies, give their poses and the events of their lives. `self` is what `create` gave.
/// All functions run on one thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct GrainsTable {
    /// Name and version, for the log. The name also tells states of checkpoints from another's.
    pub program: *const c_char,
    /// Checks scene and parameters, and says what the grains need. Cheap.
    pub describe: extern "C" fn(*const RunSetup, *mut OwnDescription) -> c_int,
    /// Makes the grains for the assigned step; null if it cannot.
    pub create: extern "C" fn(*const RunSetup) -> *mut c_void,
    /// Points to the bodies that appeared or disappeared at the last window's end, at first to all, and gives
    /// their number. They stay the component's own, and valid until the next call.
    pub events: extern "C" fn(*mut c_void, *mut *const BodyEvent) -> usize,
    /// Writes the states of all living bodies, in ascending order of their ids.
    pub state: extern "C" fn(*mut c_void, *mut BodyState, usize) -> c_int,
    /// Advances through a window in so many substeps, each under the same loads; none without a fluid.
    pub advance: extern "C" fn(*mut c_void, u32, *const Load, usize) -> c_int,
    /// Writes the values of the signals, in the order of the description; null if there are none.
    pub signals: Option<extern "C" fn(*mut c_void, *mut f64, usize)>,
    /// Names the state, to keep it and to put it back; null if there is none.
    pub exchange_state: Option<extern "C" fn(*mut c_void, *mut ComponentState) -> c_int>,
    /// Ends the grains.
    pub destroy: extern "C" fn(*mut c_void),
}

// SAFETY: a table of functions and a constant text, made before any thread is.
unsafe impl Send for GrainsTable {}
// SAFETY: as above.
unsafe impl Sync for GrainsTable {}

static TABLE: OnceLock<GrainsTable> = OnceLock::new();

/// Takes part in a run as these grains; gives the exit code of the process.
///
/// # Safety
/// `table` is whole, and its functions do what it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_grains_main(table: *const GrainsTable) -> c_int {
    // SAFETY: the caller's promise.
    let _ = TABLE.set(unsafe { *table });
    number_of(tremie_sdk::main::<AsGrains<CGrains>>()).into()
}

fn table() -> &'static GrainsTable {
    TABLE.get().expect("tremie_grains_main has set it")
}

/// Grains that functions of C are.
struct CGrains {
    made: Made,
    signals: usize,
    /// Bodies that appeared or disappeared at the last window's end.
    events: Vec<BodyEvent>,
    /// Living bodies.
    count: usize,
}

impl CGrains {
    /// Takes the events of the window that has ended, and counts who lives.
    fn ask_events(&mut self) {
        let mut at: *const BodyEvent = std::ptr::null();
        let count = (table().events)(self.made.own, &raw mut at);
        self.events.clear();
        if !at.is_null() {
            // SAFETY: the table's promise: so many events stand there.
            self.events.extend_from_slice(unsafe { std::slice::from_raw_parts(at, count) });
        }
        for event in &self.events {
            match event.kind {
                BodyEvent::ADDED => self.count += 1,
                _ => self.count = self.count.saturating_sub(1),
            }
        }
    }
}

impl Grains for CGrains {
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
        let mut grains = Self { made, signals, events: Vec::new(), count: 0 };
        grains.ask_events();
        Ok(grains)
    }

    fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    fn count(&self) -> usize {
        self.count
    }

    fn state(&self, bodies: &mut [BodyState]) {
        let code = (table().state)(self.made.own, bodies.as_mut_ptr(), bodies.len());
        if let Err(error) = outcome("state", code) {
            // The sdk lets no error through here; it takes a panic's text as the component's failure.
            std::panic::resume_unwind(Box::new(error.0));
        }
    }

    fn advance(&mut self, substeps: u32, loads: &[Load]) -> Result<(), SolverError> {
        let code = (table().advance)(self.made.own, substeps, loads.as_ptr(), loads.len());
        outcome("advance", code)?;
        self.ask_events();
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        let Some(exchange) = table().exchange_state else {
            return state.unfit("the grains have a version of their state and no exchange_state");
        };
        state.value("count", &mut self.count)?;
        ComponentState::exchange(state, |state| exchange(self.made.own, state))?;
        if state.restores() {
            let count = self.count;
            self.ask_events();
            self.count = count;
        }
        Ok(())
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        self.made.push_signals(table().signals, self.signals, values);
    }
}
