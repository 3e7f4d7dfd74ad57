//! Events of bodies, checked before they are applied.

use crate::error::FluidError;
use crate::grid::Grid;
use crate::units::Units;
use std::sync::Arc;
use tremie_geometry::Surface;
use tremie_messages::BodyEvent;

/// The surface of the part that an event adds.
pub fn surface_of<'a>(
    event: &BodyEvent,
    surfaces: &'a [Option<Arc<Surface>>],
) -> Option<&'a Arc<Surface>> {
    let part = usize::try_from(event.table).ok().filter(|_| event.shape == BodyEvent::PART)?;
    surfaces.get(part)?.as_ref()
}

/// Checks one event against the ids that live when it comes, and changes them.
pub fn check(
    event: &BodyEvent,
    ids: &mut Vec<u64>,
    units: &Units,
    grid: &Grid,
    surfaces: &[Option<Arc<Surface>>],
) -> Result<(), FluidError> {
    let id = event.id;
    match (event.kind, ids.binary_search(&id)) {
        (BodyEvent::ADDED, _)
            if event.shape != BodyEvent::SPHERE && event.shape != BodyEvent::PART =>
        {
            Err(FluidError::UnknownEvent { id, kind: event.kind, shape: event.shape })
        }
        (BodyEvent::ADDED, _)
            if event.shape == BodyEvent::PART && surface_of(event, surfaces).is_none() =>
        {
            Err(FluidError::UnknownPart { id, part: event.table, parts: surfaces.len() })
        }
        (BodyEvent::ADDED, Ok(_)) => Err(FluidError::AddedTwice { id }),
        (BodyEvent::ADDED, Err(place)) => {
            ids.insert(place, id);
            let part = surface_of(event, surfaces);
            let radius = part.map_or(event.size[0], |surface| surface.bounding_radius());
            if !(radius.is_finite() && radius > 0.0) {
                return Err(FluidError::Radius { id, radius });
            }
            let edges = grid.n.map(|n| f64::from(n) * units.cell);
            let longest = edges[0].max(edges[1]).max(edges[2]);
            for a in 0..3 {
                let edge = if grid.periodic[a] { edges[a] } else { longest };
                let limited = grid.periodic[a] || part.is_none();
                if limited && 2.0 * radius > edge {
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
