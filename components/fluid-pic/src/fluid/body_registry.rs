//! The bodies of a run by their ids: what does not change about them.

use crate::fluid::contact_prediction::LastingForce;
use crate::fluid::error::FluidError;
use tremie_messages::{BodyEvent, BodyState};

/// A living body.
#[derive(Clone, Debug)]
pub struct KnownBody {
    /// What added it.
    pub event: BodyEvent,
    /// Its state when the last window ended.
    pub state: Option<BodyState>,
    /// What it feels besides fluid and weight.
    pub lasting: LastingForce,
}

/// The living bodies, sorted by id.
#[derive(Clone, Debug, Default)]
pub struct BodyRegistry {
    /// The bodies.
    pub bodies: Vec<KnownBody>,
}

impl BodyRegistry {
    /// Applies a list of events, or none of it.
    ///
    /// # Errors
    /// A body added twice or removed without being there, an unknown kind, no size.
    pub fn apply(&mut self, events: &[BodyEvent]) -> Result<(), FluidError> {
        let mut next = self.bodies.clone();
        for event in events {
            let place = next.binary_search_by_key(&event.id, |body| body.event.id);
            let wrong = |why| FluidError::Body { id: event.id, why };
            match (event.kind, place) {
                (BodyEvent::ADDED, Err(place)) => {
                    if !(event.size[0].is_finite() && event.size[0] > 0.0) {
                        return Err(wrong("its size is not positive"));
                    }
                    let is_free = matches!(event.motion, BodyEvent::FREE | BodyEvent::SLIDER);
                    if is_free && !(event.mass.is_finite() && event.mass > 0.0) {
                        return Err(wrong("it is free to move, and its mass is not positive"));
                    }
                    let lasting = LastingForce::default();
                    next.insert(place, KnownBody { event: *event, state: None, lasting });
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
    pub fn check(&self, states: &[BodyState]) -> Result<(), FluidError> {
        let pairs = self.bodies.iter().zip(states);
        let other = pairs.clone().find(|(body, state)| body.event.id != state.id);
        if other.is_some() || self.bodies.len() != states.len() {
            let id = other.map(|(_, state)| state.id);
            return Err(FluidError::States {
                expected: self.bodies.len(),
                found: states.len(),
                id,
            });
        }
        match states.iter().find(|state| !state.is_finite()) {
            Some(state) => Err(FluidError::NotFinite { id: state.id }),
            None => Ok(()),
        }
    }
}
