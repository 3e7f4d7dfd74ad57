//! Errors while a run is under way.

use tremie_fluid_kit::bodies::body_registry::BodyError;

/// Failure of the fluid during a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FluidError {
    /// Bodies or states that cannot be taken.
    #[error(transparent)]
    Bodies(#[from] BodyError),
    /// The pressure's iteration ended without a solution.
    #[error(
        "the pressure at {time:.6} s was not found in {iterations} iterations: an imbalance of {residual:.3e} m/s is \
         left; take a shorter time_step, or look for a space that is filled and closed while a body is pushed into it"
    )]
    Pressure {
        /// Simulated time [s].
        time: f64,
        /// Iterations made.
        iterations: usize,
        /// Imbalance that is left [m/s].
        residual: f64,
    },
    /// Something grew without bound.
    #[error(
        "the fluid's velocity is no longer finite at {time:.6} s: take a shorter time_step, or a larger expected_speed"
    )]
    BlewUp {
        /// Simulated time [s].
        time: f64,
    },
}
