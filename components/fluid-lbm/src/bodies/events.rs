//! Events of bodies, checked before they are applied.

use crate::bodies::body_shapes::BodyShapes;
use crate::lattice::error::FluidError;
use crate::lattice::units::Units;
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::BodyEvent;

/// Checks one event against the ids that live when it comes, and changes them.
pub fn check(
    event: &BodyEvent,
    ids: &mut Vec<u64>,
    units: &Units,
    grid: &Grid,
    catalogue: &BodyShapes,
) -> Result<(), FluidError> {
    let id = event.id;
    match (event.kind, ids.binary_search(&id)) {
        (BodyEvent::ADDED, Ok(_)) => Err(FluidError::AddedTwice { id }),
        (BodyEvent::ADDED, Err(place)) => {
            let surface = catalogue.surface(event)?;
            ids.insert(place, id);
            let radius = surface.as_ref().map_or(event.size[0], |s| s.bounding_radius());
            if !(radius.is_finite() && radius > 0.0) {
                return Err(FluidError::Radius { id, radius });
            }
            let edges = grid.n.map(|n| f64::from(n) * units.cell);
            let longest = edges[0].max(edges[1]).max(edges[2]);
            // Of parts the scene's check has seen to it that they do not meet themselves.
            for a in (0..3).filter(|_| event.shape != BodyEvent::PART) {
                let edge = if grid.periodic[a] { edges[a] } else { longest };
                if 2.0 * radius > edge {
                    return Err(FluidError::TooWide { id, diameter: 2.0 * radius, edge });
                }
            }
            Ok(())
        }
        (BodyEvent::REMOVED, Ok(place)) => {
            ids.remove(place);
            Ok(())
        }
        (BodyEvent::REMOVED, Err(_)) => Err(FluidError::NotThere { id }),
        _ => Err(FluidError::UnknownEvent { id, kind: event.kind, shape: event.shape }),
    }
}
