//! The bodies of a run by their ids: what does not change about them.

use serde::{Deserialize, Serialize};
use tremie_messages::{BodyEvent, BodyState};

/// Bodies or states that a fluid cannot take.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BodyError {
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
}

fn named(id: Option<u64>) -> String {
    id.map_or(String::new(), |id| format!(", of which body {id} is the first that does not fit"))
}

/// A living body, with what a fluid keeps of its own about it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KnownBody<T> {
    /// What added it.
    pub event: BodyEvent,
    /// Its state when the last window ended.
    pub state: Option<BodyState>,
    /// The fluid's own.
    pub own: T,
}

/// The living bodies, sorted by id.
#[derive(Clone, Debug, Default)]
pub struct BodyRegistry<T> {
    /// The bodies.
    pub bodies: Vec<KnownBody<T>>,
}

impl<T: Clone + Default> BodyRegistry<T> {
    /// Applies a list of events, or none of it.
    ///
    /// # Errors
    /// A body added twice or removed without being there, an unknown kind, no size.
    pub fn apply(&mut self, events: &[BodyEvent]) -> Result<(), BodyError> {
        let mut next = self.bodies.clone();
        for event in events {
            let place = next.binary_search_by_key(&event.id, |body| body.event.id);
            let wrong = |why| BodyError::Body { id: event.id, why };
            match (event.kind, place) {
                (BodyEvent::ADDED, Err(place)) => {
                    if !(event.size[0].is_finite() && event.size[0] > 0.0) {
                        return Err(wrong("its size is not positive"));
                    }
                    let is_free = matches!(event.motion, BodyEvent::FREE | BodyEvent::SLIDER);
                    if is_free && !(event.mass.is_finite() && event.mass > 0.0) {
                        return Err(wrong("it is free to move, and its mass is not positive"));
                    }
                    next.insert(place, KnownBody { event: *event, state: None, own: T::default() });
                }
                (BodyEvent::REMOVED, Ok(place)) => {
                    next.remove(place);
                }
                (BodyEvent::ADDED, Ok(_)) => return Err(wrong("it is there already")),
                (BodyEvent::REMOVED, Err(_)) => {
                    return Err(wrong("it is to be removed, and is not there"));
                }
                _ => return Err(wrong("the kind of its event is unknown")),
            }
        }
        self.bodies = next;
        Ok(())
    }

    /// Checks that states are those of the living bodies.
    ///
    /// # Errors
    /// Another number or order, numbers that are not finite.
    pub fn check(&self, states: &[BodyState]) -> Result<(), BodyError> {
        let pairs = self.bodies.iter().zip(states);
        let other = pairs.clone().find(|(body, state)| body.event.id != state.id);
        if other.is_some() || self.bodies.len() != states.len() {
            let id = other.map(|(_, state)| state.id);
            return Err(BodyError::States { expected: self.bodies.len(), found: states.len(), id });
        }
        match states.iter().find(|state| !state.is_finite()) {
            Some(state) => Err(BodyError::NotFinite { id: state.id }),
            None => Ok(()),
        }
    }
}
