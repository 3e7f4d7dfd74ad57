//! Plane scenes in cells.

use tremie_messages::scene::{Face, Scene};

/// A plane scene as a layer of cells of an edge [m], about the middle of its depth; another as it
/// is.
pub fn flattened(scene: &Scene, cell: f64) -> Scene {
    let mut flat = scene.clone();
    if let Some(axis) = scene.domain.across {
        let domain = &mut flat.domain;
        let middle = 0.5 * (domain.min[axis] + domain.max[axis]);
        (domain.min[axis], domain.max[axis]) = (middle - 0.5 * cell, middle + 0.5 * cell);
        domain.faces[axis] = [Face::Symmetry, Face::Symmetry];
    }
    flat
}
