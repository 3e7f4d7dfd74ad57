//! Loads on the parts of a scene.

use serde::{Deserialize, Serialize};
use tremie_messages::scene::{Motion, Scene};
use tremie_messages::{BodyEvent, Load};

/// The loads on all parts, mean over a window.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PartLoads(Vec<PartLoad>);

/// The load on a part that may move.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct PartLoad {
    is_fixed: bool,
    /// The body that a part is which moves.
    body: Option<u64>,
    load: Load,
}

impl PartLoads {
    /// Of the parts of a scene.
    pub fn new(scene: &Scene) -> Self {
        let of = |motion: &Motion| PartLoad {
            is_fixed: *motion == Motion::Fixed,
            ..PartLoad::default()
        };
        Self(scene.parts.iter().map(|part| of(&part.motion)).collect())
    }

    /// Learns which parts are which bodies.
    pub fn apply(&mut self, events: &[BodyEvent]) {
        for event in events.iter().filter(|event| event.shape == BodyEvent::PART) {
            if let Some(part) = self.0.get_mut(event.table as usize) {
                part.body = (event.kind == BodyEvent::ADDED).then_some(event.id);
            }
        }
    }

    /// Keeps the loads on parts that move; `loads` are those on all bodies, sorted by id.
    pub fn note(&mut self, loads: &[Load]) {
        for part in &mut self.0 {
            let place =
                part.body.and_then(|id| loads.binary_search_by_key(&id, |load| load.id).ok());
            part.load = place.map_or_else(Load::default, |place| loads[place]);
        }
    }

    /// The load on each part of the scene; of those that are fixed as `on_fixed` has them, in their
    /// order.
    pub fn loads<'a>(&'a self, on_fixed: &'a [Load]) -> impl Iterator<Item = &'a Load> {
        let mut fixed = on_fixed.iter();
        self.0.iter().map(move |part| {
            let still = if part.is_fixed { fixed.next() } else { None };
            still.unwrap_or(&part.load)
        })
    }
}
