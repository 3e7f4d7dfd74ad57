//! The manifest's table of the scene.

use super::{
    BodiesTable, ContactTable, DomainTable, DragBandTable, FluidTable, GapTable, HopperTable,
    InletTable, MaterialTable, OutletTable, PartTable, ProbeTable, ProfilesTable, ShapeTable,
    SurfaceTable,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tremie_messages::units::{Acceleration, Length};

/// What is simulated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SceneTable {
    /// Acceleration of gravity (default: none).
    pub gravity: Option<[Acceleration; 3]>,
    /// The box in which everything happens.
    pub domain: DomainTable,
    /// The fluid's material; left out for a dry run.
    pub fluid: Option<FluidTable>,
    /// Materials of bodies, parts, surfaces and walls, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub materials: BTreeMap<String, MaterialTable>,
    /// Walls inside the domain.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneTable>,
    /// Rigid parts with closed surfaces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartTable>,
    /// Hoppers, which become parts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hoppers: Vec<HopperTable>,
    /// Seals of rubber: surfaces that change their shape, each carried by a part.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceTable>,
    /// Shapes of polyhedra, besides tetrahedron, cube, octahedron, dodecahedron and icosahedron.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shapes: Vec<ShapeTable>,
    /// Bodies, in sets of one material and motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bodies: Vec<BodiesTable>,
    /// Where bodies come from during the run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inlets: Vec<InletTable>,
    /// Where they go to.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub outlets: Vec<OutletTable>,
    /// Boxes in which grains are braked.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub drag_bands: Vec<DragBandTable>,
    /// Contact laws: of pairs of materials, and of all pairs that no other entry names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<ContactTable>,
    /// Where the run measures the flow.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<ProbeTable>,
    /// Tables of what grains do in the bins of a box.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<ProfilesTable>,
    /// Gaps that open and close.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<GapTable>,
}

/// A plane wall.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct PlaneTable {
    /// A point on the plane. Required.
    pub point: Option<[Length; 3]>,
    /// Direction into the space of the bodies, of any length but zero. Required.
    pub normal: Option<[f64; 3]>,
    /// Its material, for contacts (default: the domain's).
    pub material: Option<String>,
}
