//! Columns of a profile's tables.

use std::io;
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::GrainProfile;

const AXES: [&str; 3] = ["x", "y", "z"];

/// A table of a profile, as it came.
pub struct ProfileTable {
    /// Window of its last sample.
    pub window: u64,
    /// Simulated time of its begin and end [s].
    pub times: [f64; 2],
    /// Number of samples.
    pub samples: u64,
    /// Its bins.
    pub bins: Vec<ProfileBin>,
}

impl ProfileTable {
    /// A table that ended with a window.
    pub fn new(window: u64, header: &ProfileHeader, bins: &[ProfileBin]) -> Self {
        let times = [header.begin, header.end];
        Self { window, times, samples: header.samples, bins: bins.to_vec() }
    }
}

/// Names of the columns that come before those of [`ProfileBin::COLUMNS`].
pub const OF_TABLE: [(&str, &str); 3] = [("begin", "s"), ("end", "s"), ("samples", "1")];

/// Names of the binned axes.
pub fn axes(profile: &GrainProfile) -> impl Iterator<Item = &'static str> + '_ {
    profile.axes.iter().map(|along| AXES[along.axis])
}

/// The first row.
///
/// # Errors
/// None that is known: the row is made in memory.
pub fn head(profile: &GrainProfile) -> io::Result<Vec<u8>> {
    let mut row = csv::Writer::from_writer(Vec::new());
    let places = axes(profile).map(|axis| (axis, "m"));
    let all = OF_TABLE.into_iter().chain(places).chain(ProfileBin::COLUMNS);
    row.write_record(all.map(|(name, unit)| format!("{name} [{unit}]")))?;
    row.into_inner().map_err(|error| error.into_error())
}

/// The rows of a table.
///
/// # Errors
/// None that is known: the rows are made in memory.
pub fn rows(profile: &GrainProfile, table: &ProfileTable) -> io::Result<Vec<u8>> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    let [begin, end] = table.times;
    for (k, bin) in table.bins.iter().enumerate() {
        // Rust prints the shortest decimal that reads back as the same bits.
        let fixed = [begin.to_string(), end.to_string(), table.samples.to_string()];
        let places = profile.middles(k).map(|x| x.to_string());
        let values = bin.values().into_iter().map(|value| value.to_string());
        rows.write_record(fixed.into_iter().chain(places).chain(values))?;
    }
    rows.into_inner().map_err(|error| error.into_error())
}
