//! Bodies as they are announced to the other components: bodies at the start, and bodies that come
//! and go.

use crate::bodies::body_arrays::PlacedSphere;
use crate::bodies::placed_parts::PlacedPart;
use tremie_messages::{body::BodyEvent, scene::Motion};

/// Spheres by their order, then the parts that move.
pub(crate) fn initial(spheres: &[PlacedSphere], parts: &[PlacedPart]) -> Vec<BodyEvent> {
    let mut events: Vec<BodyEvent> = (0..).zip(spheres).map(|(id, s)| added(id, s)).collect();
    for (table, part) in (0..).zip(parts).filter(|(_, part)| part.moves()) {
        events.push(BodyEvent {
            id: events.len() as u64,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::PART,
            motion: part.slider().map_or(BodyEvent::PRESCRIBED, |_| BodyEvent::SLIDER),
            set: 0,
            mass: part.slider().map_or(0.0, |slider| slider.mass),
            size: [part.shape.bounding_radius(), 0.0, 0.0],
            table,
        });
    }
    events
}

/// A sphere or polyhedron that is there from now on.
pub(crate) fn added(id: u64, sphere: &PlacedSphere) -> BodyEvent {
    BodyEvent {
        id,
        kind: BodyEvent::ADDED,
        shape: match (sphere.solid, sphere.length) {
            (Some(_), _) => BodyEvent::POLYHEDRON,
            (None, Some(_)) => BodyEvent::CYLINDER,
            (None, None) => BodyEvent::SPHERE,
        },
        motion: match sphere.motion {
            Motion::Free => BodyEvent::FREE,
            Motion::Fixed => BodyEvent::FIXED,
            Motion::Prescribed(_) | Motion::Timed(_) => BodyEvent::PRESCRIBED,
            Motion::Slider(_) => BodyEvent::SLIDER,
        },
        set: sphere.set as u32,
        mass: sphere.mass,
        size: [
            sphere.ball.radius,
            sphere.solid.map(|solid| solid.size).or(sphere.length).unwrap_or(0.0),
            0.0,
        ],
        table: sphere.solid.map_or(0, |solid| u64::from(solid.shape)),
    }
}

/// A sphere that is not there any more.
pub(crate) fn removed(id: u64, set: u32, radius: f64, mass: f64) -> BodyEvent {
    BodyEvent {
        id,
        kind: BodyEvent::REMOVED,
        shape: BodyEvent::SPHERE,
        motion: BodyEvent::FREE,
        set,
        mass,
        size: [radius, 0.0, 0.0],
        table: 0,
    }
}
