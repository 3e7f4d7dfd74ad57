//! Errors while a run is under way.

/// Failure of the fluid during a run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FluidError {
    /// A body that cannot be taken.
    #[error("body {id} cannot be taken: {why}")]
    Body {
        /// Its id.
        id: u64,
        /// Reason, a few words.
        why: &'static str,
    },
    /// States that are not those of the living bodies.
    #[error("expected the states of {expected} bodies in the order of their ids, found {found}{}", named(*.id))]
    States {
        /// Number of living bodies.
        expected: usize,
        /// Number of states.
        found: usize,
        /// The first id that does not fit.
        id: Option<u64>,
    },
    /// A state that is not finite.
    #[error("the state of body {id} is not finite")]
    NotFinite {
        /// Its id.
        id: u64,
    },
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

fn named(id: Option<u64>) -> String {
    id.map_or(String::new(), |id| format!(", of which body {id} is the first that does not fit"))
}
