//! Observers of C.

use crate::component::{Made, described};
use crate::description::OwnDescription;
use crate::failure::outcome;
use crate::setup::RunSetup;
use crate::text::{c_text, text_of};
use std::ffi::{c_char, c_int, c_void};
use std::sync::OnceLock;
use tremie_messages::frame::BodySample;
use tremie_messages::start::{Description, Signal, Watches};
use tremie_messages::{BodyState, Problem};
use tremie_sdk::{AsObserver, Moment, Observer, ObserverError, Setup, number_of};

/// A body as an observer sees it.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FrameBody {
    /// Pose and velocity.
    pub state: BodyState,
    /// Radius of a sphere; of a part, that about its reference point that holds it [m].
    pub radius: f64,
    /// Mass [kg].
    pub mass: f64,
    /// Index into the scene's body sets.
    pub set: u32,
    /// One of `tremie_body_event`'s shapes.
    pub shape: u32,
    /// One of `tremie_body_event`'s motions.
    pub motion: u32,
    /// Index into the scene's list of parts, for a part; else 0.
    pub part: u32,
}

const _: () = assert!(size_of::<FrameBody>() == size_of::<BodySample>());

/// An observer: sees frames, and changes nothing. `self` is what `create` gave. All functions run on one thread.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ObserverTable {
    /// Name and version, for the log.
    pub program: *const c_char,
    /// Checks the parameters; nothing is opened yet.
    pub describe: extern "C" fn(*const RunSetup, *mut OwnDescription) -> c_int,
    /// Opens outputs; null if it cannot.
    pub create: extern "C" fn(*const RunSetup) -> *mut c_void,
    /// All bodies at one moment: sender, window, simulated time [s], bodies. Null if they are not wanted.
    pub bodies: Option<
        extern "C" fn(*mut c_void, *const c_char, u64, f64, *const FrameBody, usize) -> c_int,
    >,
    /// A signal of a component at one moment: sender, window, simulated time [s], name, value. Null if they are
    /// not wanted.
    pub signal:
        Option<extern "C" fn(*mut c_void, *const c_char, u64, f64, *const c_char, f64) -> c_int>,
    /// The run is over, and every frame was delivered.
    pub close: extern "C" fn(*mut c_void) -> c_int,
    /// Ends the observer.
    pub destroy: extern "C" fn(*mut c_void),
}

// SAFETY: a table of functions and a constant text, made before any thread is.
unsafe impl Send for ObserverTable {}
// SAFETY: as above.
unsafe impl Sync for ObserverTable {}

static TABLE: OnceLock<ObserverTable> = OnceLock::new();

/// Takes part in a run as this observer; gives the exit code of the process.
///
/// # Safety
/// `table` is whole, and its functions do what it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn tremie_observer_main(table: *const ObserverTable) -> c_int {
    // SAFETY: the caller's promise.
    let _ = TABLE.set(unsafe { *table });
    number_of(tremie_sdk::main::<AsObserver<CObserver>>()).into()
}

fn table() -> &'static ObserverTable {
    TABLE.get().expect("tremie_observer_main has set it")
}

/// An observer that functions of C are.
struct CObserver {
    made: Made,
}

/// An observer that fails has lost an output, as far as anybody can know.
fn lost(function: &str, code: c_int) -> Result<(), ObserverError> {
    outcome(function, code).map_err(|error| ObserverError::Output(error.0))
}

impl Observer for CObserver {
    const PROGRAM: &'static str = "tremie-c";

    fn program() -> String {
        // SAFETY: the table is whole.
        unsafe { text_of(table().program) }
    }

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let described = described(setup, table().describe)?;
        let watches = Watches {
            bodies: table().bodies.is_some(),
            signals: table().signal.is_some(),
            slices: false,
            log: false,
            ..Watches::default()
        };
        // Nothing of its outputs can be put back: a run that goes on begins them anew.
        Ok(Description { watches, state: None, ..described })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let made = Made::new(setup, table().create, table().destroy)?;
        Ok(Self { made })
    }

    fn bodies(
        &mut self,
        from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        let Some(function) = table().bodies else { return Ok(()) };
        let from = c_text(from);
        let values = bodies.as_ptr().cast();
        let code =
            function(self.made.own, from.as_ptr(), at.stamp.window, at.time, values, bodies.len());
        lost("bodies", code)
    }

    fn signals(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError> {
        let Some(function) = table().signal else { return Ok(()) };
        let from = c_text(from);
        for (signal, value) in names.iter().zip(values) {
            let name = c_text(&signal.name);
            let (window, time) = (at.stamp.window, at.time);
            let code = function(self.made.own, from.as_ptr(), window, time, name.as_ptr(), *value);
            lost("signal", code)?;
        }
        Ok(())
    }

    fn close(&mut self, _: u64) -> Result<String, ObserverError> {
        lost("close", (table().close)(self.made.own))?;
        Ok(String::new())
    }
}
