//! The surfaces of bodies that are no spheres: those of the scene's parts that move, and its shapes
//! of polyhedra, at the size of each.

use crate::bodies::mesh_body::MeshBody;
use crate::bodies::pose_rounding::Rounding;
use crate::lattice::error::FluidError;
use std::sync::Arc;
use tremie_geometry::{Convex, Surface};
use tremie_messages::BodyEvent;
use tremie_messages::scene::Scene;

/// Shapes that bodies can have besides spheres.
#[derive(Clone, Debug, Default)]
pub struct BodyShapes {
    /// Surfaces of the parts that move, by index of the part, and how exactly they are followed.
    parts: Vec<Option<Arc<Surface>>>,
    roundings: Vec<Rounding>,
    /// The shapes of polyhedra, of unit size; none where the corners enclose no volume.
    shapes: Vec<Option<Convex>>,
    /// Rounding of the poses of polyhedra.
    of_polyhedra: Rounding,
}

impl BodyShapes {
    /// Of a scene, whose moving parts have the given surfaces and roundings; polyhedra are found at
    /// positions `step` apart [cells], and turned by small steps from `upright`.
    pub fn new(
        scene: &Scene,
        parts: Vec<Option<Arc<Surface>>>,
        roundings: Vec<Rounding>,
        (upright, step): ([f64; 4], f64),
    ) -> Self {
        let unit = |vertices: &[[f64; 3]]| Some(Convex::hull(vertices).ok()?.unit());
        let shapes = scene.shapes.iter().map(|shape| unit(&shape.vertices)).collect();
        let of_polyhedra = Rounding { position: [0.0; 3], orientation: upright, step };
        Self { parts, roundings, shapes, of_polyhedra }
    }

    /// The surface of a body that an event adds, in its frame [m]; none of a sphere.
    ///
    /// # Errors
    /// Parts that do not move, shapes and sizes that make no surface, what is unknown.
    pub fn surface(&self, event: &BodyEvent) -> Result<Option<Arc<Surface>>, FluidError> {
        let BodyEvent { id, kind, shape, table, .. } = *event;
        let place = usize::try_from(table).unwrap_or(usize::MAX);
        match shape {
            BodyEvent::SPHERE => Ok(None),
            BodyEvent::PART => {
                let surface = self.parts.get(place).cloned().flatten();
                let parts = self.parts.len();
                surface.map(Some).ok_or(FluidError::UnknownPart { id, part: table, parts })
            }
            BodyEvent::POLYHEDRON => {
                let diameter = event.size[1];
                if !(diameter.is_finite() && diameter > 0.0) {
                    return Err(FluidError::Radius { id, radius: 0.5 * diameter });
                }
                let surface = self.shapes.get(place).and_then(Option::as_ref).and_then(|shape| {
                    let mut mesh = shape.mesh();
                    mesh.vertices.iter_mut().flatten().for_each(|x| *x *= diameter);
                    Surface::new(mesh).ok()
                });
                let shapes = self.shapes.len();
                let surface = surface.map(|surface| Some(Arc::new(surface)));
                surface.ok_or(FluidError::UnknownShape { id, shape: table, shapes })
            }
            _ => Err(FluidError::UnknownEvent { id, kind, shape }),
        }
    }

    /// The body that an event adds, which was checked; none for a sphere. `cell` is the edge of one
    /// [m].
    pub fn body(&self, event: &BodyEvent, cell: f64) -> Option<Box<MeshBody>> {
        let surface = self.surface(event).ok()??;
        let (index, rounding) = match event.shape {
            BodyEvent::PART => (event.table as usize, self.roundings[event.table as usize]),
            _ => (MeshBody::NO_PART, self.of_polyhedra),
        };
        Some(Box::new(MeshBody::new(index, surface, rounding, cell)))
    }
}
