//! The manifest's tables of deformable surfaces.

use super::parts::RotationTable;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Length, Stiffness};

/// A seal of rubber: the surface that a section sweeps when it turns about the z axis of its frame,
/// bonded to a part that carries it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct SurfaceTable {
    /// Name, unique among surfaces and parts: letters, digits, `-` and `_`. Required.
    pub name: Option<String>,
    /// Name of the part that carries it. Required.
    pub carrier: Option<String>,
    /// The table of its force and shapes, as `tremie rubber make-table` writes it; its path is
    /// relative to the manifest's folder. Required.
    pub table: Option<String>,
    /// Where the origin of the table's frame is in the carrier's (default: at its origin). The
    /// table's z axis points from the seat to the carrier.
    pub position: Option<[Length; 3]>,
    /// How the table's frame is turned in the carrier's (default: not).
    pub rotation: Option<RotationTable>,
    /// Steps in which the section is turned, at least 3 (default: 60).
    pub sectors: Option<u32>,
    /// Its material, for contacts (default: the domain's).
    pub material: Option<String>,
    /// Stiffness of the whole foot on its seat, spread evenly over the foot's area at rest; the
    /// contact of the surface with walls, planes and parts other than its carrier (default: a
    /// hundred times that of the table at rest).
    pub seat_stiffness: Option<Stiffness>,
    /// Compression at the start, as that of a seal which rests on its seat (default: none).
    pub start: Option<Length>,
    /// Compression that the run is expected to reach: the table must cover it (default: not checked
    /// before the run).
    pub compression: Option<Length>,
}
