//! Convex polyhedra: their shapes, and their places at the start.

use super::Packing;
use serde::{Deserialize, Serialize};

/// A shape of polyhedra, without a size: the convex hull of its corners. The frame of a body has
/// their axes, its origin is the centroid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shape {
    /// Name, unique in the scene.
    pub name: String,
    /// Corners, at any scale.
    pub vertices: Vec<[f64; 3]>,
}

/// Polyhedra of one shape, at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polyhedra {
    /// Name of the shape.
    pub shape: String,
    /// Places and orientations at the start.
    pub placement: PolyhedronPlacement,
}

/// Places and orientations of polyhedra at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PolyhedronPlacement {
    /// Each given.
    Listed(Vec<Polyhedron>),
    /// Packed at random places and orientations, so that the spheres around them do not overlap.
    /// The fraction counts the polyhedra; diameters are of spheres of equal volume.
    Packed(Packing),
}

/// A convex polyhedron at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Polyhedron {
    /// Centroid [m].
    pub position: [f64; 3],
    /// Unit quaternion `(x, y, z, w)` from the shape's frame to the world.
    pub orientation: [f64; 4],
    /// Diameter of a sphere of equal volume [m].
    pub diameter: f64,
    /// Velocity of the centroid [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}
