//! The manifest's tables of polyhedra.

use super::parts::RotationTable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Angle, AngularVelocity, Length, Velocity};

/// A shape of polyhedra, convex. It has no size of its own: each body says how large it is. In a
/// plane scene a shape of prisms, as large as its outline is drawn. Exactly one of `vertices`,
/// `file` and `outline`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ShapeTable {
    /// Name, unique among the shapes. Required.
    pub name: Option<String>,
    /// Its corners, at any scale: 4 to 60 points, none inside the others' hull.
    pub vertices: Option<Vec<[f64; 3]>>,
    /// A file of triangles, STL or OBJ, of a closed convex solid; its path is relative to the
    /// manifest's folder.
    pub file: Option<String>,
    /// In a plane scene the corners of a section, at most 30, in any order: coordinates along the
    /// plane's two axes, as `[["-2 cm", "-1 cm"], ["2 cm", "-1 cm"], ...]` of x and z where the scene
    /// is plane across y. None lies inside the others' hull.
    pub outline: Option<Vec<[Length; 2]>>,
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

/// A prism across a plane scene at the start, as long as the domain is deep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PrismTable {
    /// Centroid; its position across the plane does not matter. Required.
    pub position: Option<[Length; 3]>,
    /// Angle by which it is turned from its outline, about the axis across the plane (default: not
    /// turned).
    pub turn: Option<Angle>,
    /// Velocity (default: at rest).
    pub velocity: Option<[Velocity; 3]>,
    /// Angular velocity (default: none).
    pub angular_velocity: Option<[AngularVelocity; 3]>,
}
