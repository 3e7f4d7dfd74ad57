//! The manifest's table of drag bands.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::units::{Length, Velocity};

/// A box in which grains are braked, so that their fall tends to a terminal speed: the drag is
/// `m g (v / terminal_speed)^2`, against the velocity. Above a bed in a domain that is periodic
/// along the flow, it lets grains that come in again settle gently.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct DragBandTable {
    /// Name, unique among drag bands, inlets, outlets and probes: letters, digits, `_`. Required.
    pub name: Option<String>,
    /// Lower corner of the box; it brakes bodies whose centre is inside. Required.
    pub min: Option<[Length; 3]>,
    /// Upper corner of the box. Required.
    pub max: Option<[Length; 3]>,
    /// Speed of a fall at which drag and weight balance; about twice that of the bed lets grains
    /// settle on it gently. Required.
    pub terminal_speed: Option<Velocity>,
}
