//! The manifest's table of profiles.

use super::AxisName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tremie_messages::scene::ProfileVelocity;
use tremie_messages::units::{Length, Time};

/// A table of what grains do in the bins of a box, averaged over time. Exactly one of `bins` and
/// `bin_width`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(in super::super) struct ProfilesTable {
    /// Name, unique among probes, gaps and profiles: letters, digits, `_`; that of its files.
    /// Required.
    pub name: Option<String>,
    /// The axis, or the two axes, along which bins follow each other. Required.
    pub along: Option<Vec<AxisName>>,
    /// How many bins, one number for each axis.
    pub bins: Option<Vec<u32>>,
    /// Their width, one for each axis: the nearest one of which a whole number fills the box.
    pub bin_width: Option<Vec<Length>>,
    /// Lower corner of the box; in a plane scene the entry across it has no meaning (default: the
    /// domain's).
    pub min: Option<[Length; 3]>,
    /// Upper corner (default: the domain's).
    pub max: Option<[Length; 3]>,
    /// Simulated time at which sampling begins; the first sample comes an interval later (default:
    /// 0 s).
    pub from: Option<Time>,
    /// Time between samples, a whole number of windows (default: each window).
    pub every: Option<Time>,
    /// Time over which a table averages, a whole number of samples: a new table begins every so
    /// long (default: the rest of the run, one table).
    pub average: Option<Time>,
    /// Velocity that counts: a grain's own at the sample, or its displacement since the sample
    /// before over the time between, as a camera sees it (default: instantaneous).
    pub velocity: Option<ProfileVelocity>,
}
