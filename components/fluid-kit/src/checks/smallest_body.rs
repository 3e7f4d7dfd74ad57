//! The smallest bodies of a scene.

use tremie_geometry::Convex;
use tremie_messages::scene::{BodySet, Placement, Scene};

/// Diameter of the smallest sphere that the scene lists or may draw [m]; a polyhedron counts as the
/// sphere of its volume.
pub fn smallest_diameter(scene: &Scene) -> Option<f64> {
    let sets = scene.bodies.iter().map(|set| set.placement.sizes().extremes()[0]);
    let inlets = scene.inlets.iter().map(|inlet| inlet.diameters.extremes()[0]);
    sets.chain(inlets).filter(|d| d.is_finite()).reduce(f64::min)
}

/// The least width of the thinnest polyhedron that the scene lists or packs [m]: a flake may be as
/// large as a ball, and no cell across.
pub fn thinnest_width(scene: &Scene) -> Option<f64> {
    let of = |set: &BodySet| {
        let Placement::Polyhedra(own) = &set.placement else { return None };
        let shape = scene.shapes.iter().find(|shape| shape.name == own.shape)?;
        let convex = Convex::hull(&shape.vertices).ok()?.unit();
        // Of prisms across a plane scene the sections count.
        let width = match scene.domain.across {
            Some(across) => convex.least_width_across(across),
            None => convex.least_width(),
        };
        Some(width * set.placement.sizes().extremes()[0])
    };
    scene.bodies.iter().filter_map(of).filter(|width| width.is_finite()).reduce(f64::min)
}
