//! Errors while a run is under way.

use crate::solver::wavelet_solver::NoGasError;
use tremie_fluid_kit::bodies::body_registry::BodyError;

/// Failure of the gas during a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GasError {
    /// Bodies or states that cannot be taken.
    #[error(transparent)]
    Bodies(#[from] BodyError),
    /// No gas is left somewhere.
    #[error("at {time:.6e} s {error}")]
    NoGas {
        /// Simulated time [s].
        time: f64,
        /// Where, and what was found.
        error: NoGasError,
    },
    /// A window that takes too many steps.
    #[error(
        "a window of {window:.3e} s at {time:.6e} s would take more than {most} steps of {step:.3e} s: the gas is much \
         faster than expected_speed says; write a shorter time_step in the fluid's settings, or look for what blows it up"
    )]
    TooManySteps {
        /// Simulated time [s].
        time: f64,
        /// Length of the window [s].
        window: f64,
        /// Longest stable step [s].
        step: f64,
        /// Most steps in a window.
        most: u32,
    },
}
