//! Loads of a fluid: one for each body, in the order of their ids, of finite numbers.

use thiserror::Error;
use tremie_messages::Load;

/// What is wrong with the loads of a window.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LoadError {
    /// Loads do not match the bodies.
    #[error(
        "{found} loads for {expected} bodies: a fluid must answer each body of the state, in its order"
    )]
    Count {
        /// Loads received.
        found: usize,
        /// Bodies.
        expected: usize,
    },
    /// A load names another body than the state does at the same place.
    #[error("load {index} is for body {found}, expected body {expected}")]
    Order {
        /// Position in the list.
        index: usize,
        /// Id that the load names.
        found: u64,
        /// Id of the body at this position.
        expected: u64,
    },
    /// A load is not a number.
    #[error("the load on body {id} is not finite: the fluid has diverged")]
    NotFinite {
        /// Id of the body.
        id: u64,
    },
}

impl LoadError {
    /// Checks that there are as many loads as bodies.
    ///
    /// # Errors
    /// If there are not.
    pub fn check_count(loads: &[Load], expected: usize) -> Result<(), Self> {
        let found = loads.len();
        if found == expected { Ok(()) } else { Err(Self::Count { found, expected }) }
    }

    /// Checks the load at a place, where that of the body `expected` belongs.
    ///
    /// # Errors
    /// If it is for another body, or not finite.
    pub fn check(index: usize, load: &Load, expected: u64) -> Result<(), Self> {
        let found = load.id;
        if found != expected {
            return Err(Self::Order { index, found, expected });
        }
        if !load.is_finite() {
            return Err(Self::NotFinite { id: found });
        }
        Ok(())
    }
}
