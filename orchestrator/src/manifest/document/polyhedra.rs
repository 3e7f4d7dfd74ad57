//! The manifest's tables of polyhedra.

use super::parts::RotationTable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{AngularVelocity, Length, Velocity};

/// A shape of polyhedra, convex. It has no size of its own: each body says how large it is. Exactly
/// one of `vertices` and `file`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ShapeTable {
    /// Name, unique among the shapes. Required.
    pub name: Option<String>,
    /// Its corners, at any scale: 4 to 32 points, none inside the others' hull.
    pub vertices: Option<Vec<[f64; 3]>>,
    /// A file of triangles, STL or OBJ, of a closed convex solid; its path is relative to the
    /// manifest's folder.
    pub file: Option<String>,
}

/// A convex polyhedron at the start. Exactly one of `edge` and `diameter`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PolyhedronTable {
    /// Centroid. Required.
    pub position: Option<[Length; 3]>,
    /// Length of its longest edge.
    pub edge: Option<Length>,
    /// Diameter of a sphere of the same volume.
    pub diameter: Option<Length>,
    /// How it is turned (default: not).
    pub rotation: Option<RotationTable>,
    /// Velocity (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
}
